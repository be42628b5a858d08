"""What the site is made of beside the pages: its order, the reference of the command and that of the Python
package."""

from __future__ import annotations

import base64
import html
import json
import os
import re
import subprocess
from pathlib import Path
from typing import Any

from math_core import LatexError, LatexToMathML
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File

ROOT = Path(__file__).parents[1]
COMMAND = Path(os.environ.get("HYSTERON", ROOT / "target/debug/hysteron"))
LINK = re.compile(r"\[([^\]]+)\]\(([^)#\s]+\.(?:md|ipynb|json))(?:#[^)]*)?\)")
FORMULA = re.compile(r'<(span|div) class="arithmatex">(.*?)</\1>', re.S)
CODE = re.compile(r"<(pre|code|script|style)\b.*?</\1>", re.S)
MATHML = LatexToMathML(fancy_error=False)
NOTEBOOK = re.compile(r"^- \[([^\]]+)\]\((notebooks/[\w-]+)\.ipynb\):", re.M)
OUTSIDE = re.compile(
    r"\[([^\]]+)\]\((?:\.\./)+(?:(?:crates|bench|python|examples|scripts)/|CONTRIBUTING\.md)[^)]*\)"
)


def on_config(config: Any) -> Any:
    """The order is that of docs/README.md: its sections, and the pages that each names, once."""
    nav: list[dict[str, Any]] = [{"Contents": "README.md"}]
    seen: set[str] = set()
    for section in (ROOT / "docs/README.md").read_text().split("\n## ")[1:]:
        title, _, body = section.partition("\n")
        pages = []
        for _, target in LINK.findall(body):
            if target not in seen and not target.endswith(".json"):
                seen.add(target)
                pages.append(target)
        nav.append({title: pages})
    nav[-1]["Reference"] += ["reference/command.md", "reference/python.md"]
    config.nav = nav
    return config


def on_files(files: Any, config: Any) -> Any:
    """The generated pages."""
    files.append(File.generated(config, "reference/command.md", content=command()))
    files.append(File.generated(config, "reference/python.md", content=package()))
    for path in (ROOT / "docs/notebooks").glob("*.ipynb"):
        files.append(File.generated(config, f"notebooks/{path.stem}.png", content=thumbnail(path)))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Links to files of the repository, which are not part of the site, become their text; notebooks of the
    gallery get their picture."""
    if page.file.src_uri == "gallery.md":
        markdown = NOTEBOOK.sub(r"- [![](\2.png)](\2.ipynb)\n    [**\1**](\2.ipynb)<br>", markdown)
    return OUTSIDE.sub(r"\1", markdown)


def on_page_content(content: str, page: Any, **_: Any) -> str:
    """LaTeX becomes MathML here, not in the browser: no script, no network, and a formula that cannot be read
    ends the build."""
    try:
        content = FORMULA.sub(mathml, content)
    except LatexError as error:
        raise PluginError(f"{page.file.src_path}: {error}") from error
    stray = re.search(r".{0,40}\$.{0,40}", CODE.sub("", content))
    if stray:
        raise PluginError(f"{page.file.src_path}: a $ that opens or closes no formula: {stray[0]}")
    return content


def mathml(formula: re.Match[str]) -> str:
    """One formula as pymdownx.arithmatex leaves it: \\(...\\) in a span, \\[...\\] in a block."""
    tag, latex = formula[1], html.unescape(formula[2]).strip()[2:-2].strip()
    if r"\tag" in latex:
        latex = rf"\begin{{equation}}{latex}\end{{equation}}"
    try:
        rendered = MATHML.convert_with_local_state(latex, displaystyle=tag == "div")
    except LatexError as error:
        raise LatexError(f"{error} in the formula {latex}") from error
    return f'<{tag} class="arithmatex">{rendered}</{tag}>'


def thumbnail(path: Path) -> bytes:
    """The picture of the cell that is tagged as thumbnail, among the outputs that a notebook is kept with."""
    for cell in json.loads(path.read_text())["cells"]:
        if "thumbnail" in cell["metadata"].get("tags", []):
            for output in cell["outputs"]:
                if "image/png" in output.get("data", {}):
                    return base64.b64decode(output["data"]["image/png"])
    raise PluginError(f"{path}: no cell with a picture is tagged as thumbnail")


def on_post_page(output: str, page: Any, **_: Any) -> str:
    """The script by which the search runs without a server is the site's own: no page asks the network for
    anything."""
    here = "../" * page.url.count("/")
    return output.replace("https://unpkg.com/iframe-worker/shim", f"{here}iframe-worker.js")


def told(*words: str) -> str:
    """What the command prints about itself."""
    run = subprocess.run(
        [COMMAND, *words], capture_output=True, text=True, check=True, env={"COLUMNS": "100"}
    )
    return run.stdout


def command() -> str:
    """Every subcommand with its help."""
    listed = told("--help").split("Commands:")[1].split("Options:")[0]
    names = re.findall(r"^  ([a-z-]+)  ", listed, re.M)
    page = [
        "# The command, flag by flag", "", "Printed by the program itself: `hysteron COMMAND --help`.", ""
    ]
    for name in names:
        if name != "help":
            page += _with_actions(name)
    return "\n".join(page)


def _with_actions(*names: str) -> list[str]:
    """Help of a subcommand, and of those that it has itself."""
    said = told(*names, "--help")
    page = [f"{'#' * (1 + len(names))} hysteron {' '.join(names)}", "", f"<pre>{html.escape(said)}</pre>", ""]
    listed = said.split("Commands:")[1].split("Options:")[0] if "\nCommands:" in said else ""
    for name in re.findall(r"^  ([a-z-]+)  ", listed, re.M):
        if name != "help":
            page += _with_actions(*names, name)
    return page


def package() -> str:
    """Everything that the package exports, from its docstrings."""
    source = (ROOT / "python/hysteron_models/__init__.py").read_text()
    names = re.findall(r'^    "([A-Za-z]\w*)",$', source.split("__all__")[1], re.M)
    page = [
        "# The Python package, name by name",
        "",
        "`import hysteron_models as hy`. A first walk: [Python](../python.md).",
        "",
    ]
    fleet = (ROOT / "python/hysteron_models/fleet/__init__.py").read_text()
    of_fleet = re.findall(r'^    "([A-Za-z]\w*)",$', fleet.split("__all__")[1], re.M)
    names = [name for name in names if name != "fleet"] + [f"fleet.{name}" for name in of_fleet]
    page += [f"::: hysteron_models.{name}\n" for name in names]
    return "\n".join(page)
