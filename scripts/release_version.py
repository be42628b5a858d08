#!/usr/bin/env python3
"""Version of a release. `release_version.py REF` prints `version=X.Y.Z` of the workspace, and fails where REF
is a tag of another version or the changelog has no section of it; `--notes X.Y.Z` prints that section."""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def version() -> str:
    """The version that all crates share."""
    text = (ROOT / "Cargo.toml").read_text(encoding="utf-8")
    found = re.search(r'\[workspace\.package\]\nversion = "([^"]+)"', text)
    if found is None:
        sys.exit("error: Cargo.toml has no version under [workspace.package]")
    others = set(re.findall(r'path = "[^"]+", version = "([^"]+)"', text)) - {found[1]}
    if others:
        sys.exit(f"error: dependencies between the crates ask for {', '.join(sorted(others))}, not {found[1]}")
    return found[1]


def notes(wanted: str) -> str | None:
    """The section of a version in the changelog."""
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    found = re.search(rf"^## \[?{re.escape(wanted)}\]?.*?\n(.*?)(?=^## |\Z)", text, re.M | re.S)
    return found[1].strip() if found else None


def main() -> None:
    """Reads the arguments."""
    if sys.argv[1:2] == ["--notes"] and len(sys.argv) == 3:
        print(notes(sys.argv[2]) or f"Hysteron {sys.argv[2]}")
        return
    ref = sys.argv[1] if len(sys.argv) > 1 else ""
    own = version()
    if ref.startswith("refs/tags/"):
        tag = ref.removeprefix("refs/tags/")
        if tag != f"v{own}":
            sys.exit(f"error: the tag is {tag}, the crates are {own}: set the version in Cargo.toml first")
        if notes(own) is None:
            sys.exit(f"error: CHANGELOG.md has no section {own}: rename Unreleased first")
    print(f"version={own}")


if __name__ == "__main__":
    main()
