"""Makes the tables of keys in docs/scene.md, and docs/scene.schema.json, from the types that read scenes.

.venv/bin/python -m tools.scene_guide
"""

import json
from argparse import ArgumentParser
from pathlib import Path

from tools.generated import between
from tumble.scenarios.schema import TABLES, json_schema, keys, title

DOCS = Path(__file__).parents[1] / "docs"
BEGIN, END = "<!-- keys: made by tools/scene_guide.py -->\n", "<!-- end of keys -->\n"


def key_tables() -> str:
    """Return a Markdown table of keys for each table of a scene file."""
    parts = []
    for head, table in TABLES.items():
        name = f"`{head}`" if head else "At the top"
        parts.append(
            f"### {name}\n\n{title(table)}\n\n| key | must be | unit | what | default |\n|---|---|---|---|---|"
        )
        for key in keys(table):
            default = "**needed**" if key.default is None else f"`{key.default}`" if key.default else ""
            meaning = key.meaning.replace("|", "\\|")
            parts.append(f"| `{key.name}` | {key.allowed} | {key.unit} | {meaning} | {default} |")
        parts.append("")
    return "\n".join(parts)


def page(text: str) -> str:
    """Return the page with new tables of keys."""
    return between(text, BEGIN, END, f"\n{key_tables()}\n")


def schema_text() -> str:
    """Return the JSON Schema as the file has it."""
    return json.dumps(json_schema(), indent=1) + "\n"


if __name__ == "__main__":
    ArgumentParser(prog="tools.scene_guide", description="Make docs/scene.md's tables and schema.").parse_args()
    guide = DOCS / "scene.md"
    guide.write_text(page(guide.read_text(encoding="utf-8")), encoding="utf-8")
    (DOCS / "scene.schema.json").write_text(schema_text(), encoding="utf-8")
