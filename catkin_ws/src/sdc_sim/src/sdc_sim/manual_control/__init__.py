"""The manual control client: keyboard, head-up display, map and views."""
