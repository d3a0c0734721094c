#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Lists the attributes that SOFA's components declare, in the form of declared_attributes.txt: per class its bases and the names, aliases
and defaults of its data and links. It reads the declarations of a folder of SOFA's sources (initData, initLink, addAlias, and attributes
that parse() asks for), not the code of a build.

Usage: list_attributes.py FOLDER [--compare TABLE] [CLASS...]
  --compare TABLE   prints what the sources have and the table has not, and the other way round; exit code 1 if there is anything"""
import argparse
import os
import re
import sys

CLASS = re.compile(r"\bclass\s+(?:SOFA_\w+\s+|\w+_API\s+)?(\w+)(?:\s+final)?\s*:\s*((?:public|virtual|protected)[^{;]+)\{")
CONSTRUCTOR = re.compile(r"\b(\w+)(?:<[^<>;{}()]*>)?::\1\s*\(")
STRUCTURES = ("DataEngine", "BaseObject", "BaseComponent", "Base", "TrackedComponent")


def closing(text, start):
    """The place after the bracket that closes the one at `start`."""
    depth = 0
    quoted = False
    for at in range(start, len(text)):
        letter = text[at]
        if letter == '"' and text[at - 1] != "\\":
            quoted = not quoted
        elif not quoted and letter in "([{":
            depth += 1
        elif not quoted and letter in ")]}":
            depth -= 1
            if depth == 0:
                return at + 1
    return len(text)


def arguments(text):
    """The parts between commas that are in no bracket and no text."""
    parts, depth, quoted, last = [], 0, False, 0
    for at, letter in enumerate(text):
        if letter == '"' and text[at - 1] != "\\":
            quoted = not quoted
        elif not quoted:
            depth += (letter in "([{<") - (letter in ")]}>" and text[at - 1:at + 1] != "->")
            if letter == "," and depth == 0:
                parts.append(text[last:at].strip())
                last = at + 1
    return [*parts, text[last:].strip()]


def plain(code):
    """Without comments, and without what only a preprocessor reads."""
    code = re.sub(r"/\*.*?\*/", " ", code, flags=re.S)
    code = re.sub(r'^((?:[^"\n/]|"(?:\\.|[^"\\\n])*"|/(?!/))*)//.*$', r"\1", code, flags=re.M)
    return re.sub(r"^\s*#.*$", "", code, flags=re.M)


def default_of(text):
    """A number, several of them or a word; None where the default is computed or empty."""
    text = re.sub(r"^\(\s*[\w: ]+\)\s*(?=[-+\w.(])", "", text.strip())  # a cast
    if text in ("true", "false"):
        return str(int(text == "true"))
    if word := re.fullmatch(r'"([\w.]*)"', text):
        return word[1] or None
    if number := re.fullmatch(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)(?:_sreal|[fuUlL]*)?", text):
        return f"{float(number[1]):.12g}"
    made = re.fullmatch(r"([\w:]*?(\w*))\s*(?:<[^()]*>)?\s*([({].*[)}])", text, flags=re.S)
    if not made or closing(made[3], 0) != len(made[3]):
        return None
    parts = [part for part in arguments(made[3][1:-1]) if part]
    if made[2] == "Vec3" and not parts:
        return "0,0,0"
    if made[2] == "vector" and made[3][0] == "(" and len(parts) == 2:  # as many as the first, each the second
        parts = parts[1:]
    values = [default_of(part) for part in parts]
    return ",".join(values) if values and None not in values else None


class Declared:
    def __init__(self):
        self.bases = {}
        self.attributes = {}  # of a class: name -> [default, aliases]
        self.members = {}  # of a class: member -> name

    def of(self, name):
        self.members.setdefault(name, {})
        return self.attributes.setdefault(name, {})

    def read(self, code, stem):
        code = plain(code)
        places = [(match.start(), match[1]) for match in CONSTRUCTOR.finditer(code)]
        for match in CLASS.finditer(code):
            names = [re.sub(r"<.*", "", part.split()[-1] if "<" not in part else re.sub(r"^.*?([\w:]+<).*", r"\1", part, flags=re.S))
                     for part in arguments(match[2])]
            names = [name.split("::")[-1] for name in names]
            self.bases[match[1]] = [name for name in names if name not in STRUCTURES]
            self.of(match[1])
            places.append((match.start(), match[1]))
        places.sort()
        for match in re.finditer(r"\binit(Data|Link)\s*\(", code):
            here = [name for start, name in places if start < match.start()]
            owner = here[-1] if here else stem
            self.add(owner, match[1] == "Link", arguments(code[match.end():closing(code, match.end() - 1) - 1]))
        for match in re.finditer(r"\baddAlias\s*\(\s*&\s*(?:this->)?(\w+)(?:\[(\w+)\])?\s*,\s*\"(\w+)\"", code):
            self.alias([name for start, name in places if start < match.start()], stem, match[1], match[3])
        for match in re.finditer(r"\bgetAttribute(?:AsFloat|AsInt|AsBool)?\s*\(\s*\"(\w+)\"", code):
            if match[1] not in ("name", "template", "type"):
                self.of(stem).setdefault(match[1], [None, []])

    def add(self, owner, is_link, words):
        names = [word for word in words if re.fullmatch(r'"[\w. ]+"', word)]
        if is_link:
            names = names[:1]
        if not names:
            return
        at = words.index(names[0])
        if not is_link and at == 2 and len(words) > 4:
            return
        name = names[0].strip('"')
        if not is_link and at == 1 and len(words) > 3 and re.fullmatch(r'"[\w.]*"', words[2]):
            name, at = words[2].strip('"'), 2  # a default that is a text comes first
        default = default_of(words[1]) if not is_link and at == 2 else None
        self.of(owner)[name] = [default, []]
        if not is_link:
            self.members[owner][words[0].strip("& ").replace("this->", "")] = name

    def alias(self, here, stem, member, alias):
        for owner in (*reversed(here[-1:]), stem, *self.members):
            if (name := self.members.get(owner, {}).get(member)) is not None:
                self.attributes[owner][name][1].append(alias)
                return
        self.of(here[-1] if here else stem).setdefault(alias, [None, []])


def sources(folder):
    for path, folders, files in os.walk(folder):
        folders.sort()
        for file in sorted(files):
            if file.endswith((".h", ".inl", ".cpp")) and not re.search(r"[/\\](?:tests?|examples|simutest)(?:[/\\]|$)", path):
                yield os.path.join(path, file)


def declared_in(folder):
    found = Declared()
    for path in sorted(sources(folder), key=lambda each: (not each.endswith(".h"), each)):
        with open(path, encoding="utf-8", errors="replace") as file:
            found.read(file.read(), os.path.splitext(os.path.basename(path))[0])
    return {name: (found.bases.get(name, []), attributes) for name, attributes in found.attributes.items()}


def read_table(path):
    table = {}
    with open(path, encoding="utf-8") as file:
        for line in file:
            if line.startswith("#") or not line.strip():
                continue
            if not line.startswith(" "):
                name, bases = line.split(":")
                attributes = {}
                table[name] = (bases.split(), attributes)
                continue
            for word in line.split():
                names, _, default = word.partition("=")
                attributes[names.split("|")[0]] = [default or None, names.split("|")[1:]]
    return table


def all_names(table, name):
    bases, attributes = table.get(name, ([], {}))
    names = {each for first, (_, aliases) in attributes.items() for each in (first, *aliases)}
    return names.union(*(all_names(table, base) for base in bases if base != name))


def written(attributes):
    lines, line = [], " "
    for name, (default, aliases) in attributes.items():
        word = "|".join([name, *aliases]) + ("" if default is None else f"={default}")
        if len(line) + 1 + len(word) > 140:
            lines.append(line)
            line = " "
        line += " " + word
    return [*lines, *([line] if line.strip() else [])]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0], usage=__doc__.split("Usage: ")[1].split("\n")[0])
    parser.add_argument("folder")
    parser.add_argument("classes", nargs="*")
    parser.add_argument("--compare", metavar="TABLE")
    given = parser.parse_args()
    found = declared_in(given.folder)
    wanted = given.classes or sorted(name for name, (_, attributes) in found.items() if attributes)
    if unknown := [name for name in wanted if name not in found]:
        sys.exit(f"list_attributes.py: no class {', '.join(unknown)} in {given.folder}")
    if given.compare:
        table = read_table(given.compare)
        differs = False
        for name in wanted:
            if name not in table:
                continue
            here, there = all_names(found, name), all_names(table, name)
            for names, text in ((here - there, "the table has not"), (there - here, "the sources have not")):
                if names:
                    print(f"{name}: {text} {' '.join(sorted(names))}")
                    differs = True
        sys.exit(differs)
    for name in wanted:
        bases, attributes = found[name]
        print(f"{name}:{''.join(' ' + base for base in bases)}", *written(attributes), sep="\n")


if __name__ == "__main__":
    main()
