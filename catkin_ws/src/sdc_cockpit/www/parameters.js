// The live parameters: a field for each. A field that is edited keeps its text until it is sent.
const $ = (id) => document.getElementById(id);

export class Parameters {
  #connection; #fields = new Map();

  constructor(connection) {
    this.#connection = connection;
    connection.addEventListener("parameters", ({ detail }) => this.#show(detail.values));
    $("parameters").addEventListener("submit", (event) => event.preventDefault());
  }

  #show(values) {
    const names = Object.keys(values);
    $("no-parameters").hidden = names.length > 0;
    if (names.join() !== [...this.#fields.keys()].join()) this.#build(names);
    for (const [name, field] of this.#fields) {
      if (document.activeElement !== field) field.value = String(Number(values[name].toPrecision(6)));
    }
  }

  #build(names) {
    const fields = new Map();
    for (const name of names) {
      fields.set(name, this.#fields.get(name) ?? this.#field(name));
    }
    this.#fields = fields;
    // A field that stays keeps its place in the page, and so its focus and text.
    for (const label of [...$("parameters").children]) if (!names.includes(label.title)) label.remove();
    names.forEach((name, i) => {
      const label = fields.get(name).parentElement;
      if ($("parameters").children[i] !== label) $("parameters").insertBefore(label, $("parameters").children[i] ?? null);
    });
  }

  #field(name) {
    const label = document.createElement("label");
    const field = document.createElement("input");
    Object.assign(field, { type: "number", step: "any", name });
    field.addEventListener("change", () => {
      if (field.value !== "" && field.validity.valid) this.#connection.send("set", { name, value: Number(field.value) });
    });
    // The path of a parameter begins with its node, which the page does not need to show.
    label.append(name.split("/").slice(2).join(" "), field);
    label.title = name;
    return field;
  }
}
