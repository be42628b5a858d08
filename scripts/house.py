#!/usr/bin/env python3
"""Counts circles: between crates, and between sibling folders (and files) of a crate's src.

    scripts/house.py            prints them; exits 1 where there is one between crates or sibling folders
    scripts/house.py --files    lists those of files too (not an error)

An arrow is a path in the source: `crate::a::…`, `super::a::…`, `mod a` does not count, nor do tests and
documentation comments.
"""
import os
import re
import sys

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "crates"))
PATH = re.compile(r"\b(crate|(?:super::)*super)((?:::\w+)*)(?:::\{([^;]*?)\})?", re.S)


def sources(folder):
    for where, folders, names in os.walk(folder):
        folders[:] = [f for f in folders if f not in ("tests", "target")]
        for name in names:
            if name.endswith(".rs") and name not in ("tests.rs",):
                yield os.path.join(where, name)


def code(path):
    """The file without comments and unit tests."""
    text = open(path, encoding="utf-8").read()
    cut = re.search(r"(?m)^#\[cfg\(test\)\]\n(#\[[^\n]*\n)*mod ", text)
    text = text[: cut.start()] if cut else text
    return "\n".join(line.split("//")[0] for line in text.splitlines())


def module(src, path):
    """Module path of a file, as a tuple."""
    parts = os.path.relpath(path, src)[:-3].split(os.sep)
    if parts[-1] in ("mod", "lib", "main"):
        parts.pop()
    return tuple(parts)


def arrows(src):
    """Arrows between the modules of a crate: (from, to), `to` as deep as there is a module."""
    modules = {module(src, path): path for path in sources(src)}
    found = set()
    for own, path in modules.items():
        for start, steps, group in PATH.findall(code(path)):
            base = () if start == "crate" else own[: max(0, len(own) - start.count("super"))]
            heads = [tuple(s for s in steps.split("::") if s)]
            if group:
                names = re.findall(r"(?:^|,)\s*(\w+)", re.sub(r"\{[^{}]*\}", "", group))
                heads = [heads[0] + (name,) for name in names]
            for head in heads:
                to = base + head
                while to and to not in modules:
                    to = to[:-1]
                if to and to != own:
                    found.add((own, to))
    return found


def circles(edges):
    """Strongly connected components of more than one node (Tarjan)."""
    graph = {}
    for a, b in edges:
        if a != b:
            graph.setdefault(a, set()).add(b)
            graph.setdefault(b, set())
    index, low, stack, on, out = {}, {}, [], set(), []

    def visit(v):
        index[v] = low[v] = len(index)
        stack.append(v)
        on.add(v)
        for w in sorted(graph[v]):
            if w not in index:
                visit(w)
                low[v] = min(low[v], low[w])
            elif w in on:
                low[v] = min(low[v], index[w])
        if low[v] == index[v]:
            component = []
            while True:
                w = stack.pop()
                on.remove(w)
                component.append(w)
                if w == v:
                    break
            if len(component) > 1:
                out.append(sorted(component))

    for v in sorted(graph):
        if v not in index:
            visit(v)
    return out


def of_crates():
    edges = set()
    for name in sorted(os.listdir(ROOT)):
        manifest = os.path.join(ROOT, name, "Cargo.toml")
        if not os.path.exists(manifest):
            continue
        text = open(manifest, encoding="utf-8").read()
        part = text.split("[dependencies]")[-1].split("\n[")[0]
        edges |= {(name, other) for other in re.findall(r"(?m)^(hysteron[\w-]*)\b", part) if other != name}
    return circles(edges)


def main():
    sys.setrecursionlimit(10_000)
    bad = of_crates()
    for circle in bad:
        print("circle of crates:", ", ".join(circle))
    files = 0
    for name in sorted(os.listdir(ROOT)):
        src = os.path.join(ROOT, name, "src")
        if not os.path.isdir(src):
            continue
        found = arrows(src)
        folders = {os.path.relpath(where, src) for where, _, _ in os.walk(src)}
        depth = max((len(a) for a, _ in found), default=0)
        for level in range(1, depth + 1):
            siblings = {}
            for a, b in found:
                if len(a) >= level and len(b) >= level and a[: level - 1] == b[: level - 1]:
                    a, b = a[:level], b[:level]
                    if a != b and os.path.join(*a) in folders and os.path.join(*b) in folders:
                        siblings.setdefault(a[:-1], set()).add((a, b))
            for edges in siblings.values():
                for circle in circles(edges):
                    bad.append(circle)
                    print(f"circle of folders in {name}:", ", ".join("::".join(m) for m in circle))
        # A file and the module it is in share a name; only files of one folder are siblings.
        same = {(a, b) for a, b in found if a[:-1] == b[:-1]}
        for circle in circles(same):
            if all(os.path.join(*m) in folders for m in circle):
                continue
            files += 1
            if "--files" in sys.argv:
                print(f"circle of files in {name}:", ", ".join("::".join(m) for m in circle))
    print(f"{len(bad)} circles of crates or folders, {files} of files")
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
