"""The page's JavaScript: ES modules, assembled into scripts that one HTML file holds and that run from file://.

A page opened from a file cannot import its modules, and importing them from data: or blob: addresses would need a
Content-Security-Policy that lets any script in from there.  So each module becomes one inline script that the policy
names by its hash: a function that returns what the module exports, after the scripts that it imports from.  Line
numbers stay, and `sourceURL` names the file in the browser's messages.
"""

import re
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

JAVASCRIPT = Path(__file__).parent / "templates" / "js"
ENTRY = "main"
# The forms that modules use; every other line that begins with import or export is refused.
IMPORT = re.compile(r'^import \{([\w\s,]+)\} from "\./([\w-]+)\.js";$', re.MULTILINE)
EXPORT = re.compile(r"^export (?=(?:async function|function|const|class) (\w+))", re.MULTILINE)
UNKNOWN = re.compile(r"^(?:import|export)\b.*", re.MULTILINE)


def page_scripts(folder: Path = JAVASCRIPT) -> list[str]:
    """Return the scripts of the page in the order in which they run, one a module that the entry needs.

    Parameters
    ----------
    folder
        Where the modules are, NAME.js each; the entry is main.js.

    Returns
    -------
    list of str
        The text of each script element.

    Raises
    ------
    ValueError
        A module imports or exports in a form that is not known here, imports what another does not export, or the
        modules import each other in a circle.
    """
    sources: dict[str, str] = {}
    needed = [ENTRY]
    while needed:
        name = needed.pop()
        if name not in sources:
            sources[name] = (folder / f"{name}.js").read_text(encoding="utf-8")
            needed += [imported for _, imported in IMPORT.findall(sources[name])]
    # Lists, not sets: the order must be the same on each run.
    imports = {name: [imported for _, imported in IMPORT.findall(text)] for name, text in sources.items()}
    try:
        order = list(TopologicalSorter(imports).static_order())
    except CycleError as error:
        raise ValueError(f"modules import each other in a circle: {' <- '.join(error.args[1])}") from None
    exports = {name: EXPORT.findall(text) for name, text in sources.items()}
    for name, missing in not_exported(sources, exports):
        raise ValueError(f"{name}.js: imports {missing}, which no module of that name exports")
    return [script(name, sources[name], exports[name]) for name in order]


def script(name: str, source: str, exports: list[str]) -> str:
    """Return the script of one module.  Raises ValueError."""
    body = IMPORT.sub(lambda found: f"const {{{found[1]}}} = {variable(found[2])};", source)
    body = EXPORT.sub("", body)
    if unknown := UNKNOWN.search(body):
        raise ValueError(f"{name}.js: {unknown[0]}: must be `import {{ NAMES }} from` or `export function|const|class`")
    # On the module's first line and after its last one, so that lines keep their numbers.
    return (
        f'const {variable(name)} = (() => {{ "use strict"; {body.rstrip()}\n'
        f"return {{ {', '.join(exports)} }}; }})();\n//# sourceURL={name}.js\n"
    )


def variable(module: str) -> str:
    """Return the name under which a script finds what a module exports."""
    return f"${module.replace('-', '_')}"


def not_exported(sources: dict[str, str], exports: dict[str, list[str]]) -> Iterator[tuple[str, str]]:
    """Yield module and name of each import that its source does not export."""
    for name, text in sources.items():
        for names, source in IMPORT.findall(text):
            for imported in filter(None, map(str.strip, names.split(","))):
                if imported not in exports[source]:
                    yield name, imported
