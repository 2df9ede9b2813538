"""``python -m docs.generator``: write anew what the documentation takes from the code."""

from docs.generator.catalogue import generated

for path, text in generated().items():
    path.write_text(text(), encoding="utf-8")
