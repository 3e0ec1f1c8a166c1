"""In programs with this folder on their path, `import sdc_sim` fails: the world is not there."""

import sys

sys.modules["sdc_sim"] = None
