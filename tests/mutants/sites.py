# SPDX-License-Identifier: LGPL-2.1-or-later
"""Where a source can be made a little wrong, and how: finds the sites of small changes in C++ in the repository's own
format (a binary operator has spaces around it, an argument list of a template has not)."""
import math
import os
import random
import re
from typing import NamedTuple

KINDS = {"sign": 0.21, "factor": 0.24, "term": 0.20, "index": 0.10, "condition": 0.18, "return": 0.07}
# How likely a site in a folder is to be chosen, beside one in another.
FOLDERS = [("components/vtk_io/", 0.5), ("components/topology/", 0.7), ("components/output/", 0.7),
           ("components/selection/", 1), ("components/", 3), ("framework/fem/", 3), ("framework/algebra/", 3),
           ("framework/mechanics/", 2.5), ("framework/simulation/", 1.5), ("framework/mesh/", 1.5), ("framework/scene/", 0.4)]
FORMULA = re.compile(r" [*/] | [+\-*/]= |\b(?:sqrt|pow|exp|log|dot|cross|norm|squaredNorm|axpy|xpay|inverse|transpose)\b")
MOST_TEXT = 6  # sources that a header of the framework may reach before it is chosen less often
HIDDEN = "@"  # stands for arguments of templates: part of a name, nothing to change
NOT_A_FORMULA = re.compile(r'"|\bthrow\b|\bstatic_assert\b|\bassert\b|\bfmt::|\bto_string\b|\btable\.add\b|\.help\(|'
                           r"\boperator\b|\bnamespace\b|\busing\b|\btypedef\b|\bdefault:")
SYMMETRIC = {"dot", "min", "max", "hypot", "swap", "minmax"}


class Site(NamedTuple):
    path: str
    start: int
    end: int
    kind: str
    new: str

    def line(self, text):
        return text.count("\n", 0, self.start) + 1

    def apply(self, text):
        """The changed text. Lines keep their numbers."""
        missing = text.count("\n", self.start, self.end) - self.new.count("\n")
        return text[:self.start] + self.new + "\n" * missing + text[self.end:]

    def before_and_after(self, text):
        """The lines that change, as one line each."""
        first, last = text.rfind("\n", 0, self.start) + 1, text.find("\n", self.end)
        changed = text[first:self.start] + self.new + text[self.end:last]
        return " ".join(text[first:last].split()), " ".join(changed.split())


def blank(text, start, end, fill=" "):
    return text[:start] + "".join(c if c == "\n" else fill for c in text[start:end]) + text[end:]


def closing(code, at, brackets="()"):
    """The place of the bracket that closes the one at `at`, or -1."""
    depth = 0
    for place in range(at, len(code)):
        if code[place] == brackets[0]:
            depth += 1
        elif code[place] == brackets[1]:
            depth -= 1
            if depth == 0:
                return place
    return -1


TEXTS = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<![\w])\'(?:\\.|[^\'\\\n])+\'|'
                   r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", re.S | re.M)


def code_of(text):
    """The text with all that is not code hidden: same length, same lines. A string stays a pair of quotes."""
    code = text
    for match in TEXTS.finditer(text):
        start, end = match.span()
        if match.group()[0] in "\"'R":
            code = blank(code, start, end)
            code = code[:start] + '"' + code[start + 1:end - 1] + '"' + code[end:]
        else:
            code = blank(code, start, end)
    for match in re.finditer(r"\b(?:template <|assert\(|static_assert\(|requires )", code):
        at = match.end() - 1
        end = closing(code, at, "<>" if code[at] == "<" else "()") if code[at] in "<(" else code.find("\n", at)
        code = blank(code, match.start(), end + 1) if end > 0 else code
    for match in re.finditer(r"(?<=\w)<(?=[^\s<=])", code):
        end = closing(code, match.start(), "<>")
        if 0 < end < match.start() + 300 and ";" not in code[match.start():end]:
            code = blank(code, match.start(), end + 1, HIDDEN)
    return code


PRIMARY = re.compile(r"[ \n]*(?:[-!*&]?)(?:[\w@:]+|\d[\w.]*(?:[eE][-+]\d+)?|(?=\())")


def primary_end(code, at):
    """Behind the operand that starts at `at`: a name, a number or a bracket, with calls, indices and members; or -1."""
    match = PRIMARY.match(code, at)
    if not match:
        return -1
    end = match.end()
    number = re.compile(r"[ \n]*-?\d[\d.']*(?:[eE][-+]?\d+)?").match(code, at)
    if number:
        end = number.end()
    while end < len(code):
        if code[end] in "([{" and not (code[end] == "{" and code[end - 1] == " "):
            end = closing(code, end, {"(": "()", "[": "[]", "{": "{}"}[code[end]]) + 1
            if end == 0:
                return -1
        elif re.compile(r"\.(?=[A-Za-z_])|->").match(code, end):
            member = re.compile(r"(?:\.|->)[\w@]+").match(code, end)
            if not member:
                return -1
            end = member.end()
        else:
            break
    return end


def term_end(code, at):
    end = primary_end(code, at)
    while end > 0 and re.compile(r"[ \n]+[*/%][ \n]").match(code, end):
        end = primary_end(code, code.index(" ", end + 1) if code[end] == " " else end + 1)
    return end


def signs(code):
    for match in re.finditer(r"(?<=[\w)\]}@] )([+-])(?=[ \n])", code):
        yield match.start(), match.end(), "sign", "-" if match.group() == "+" else "+"
        end = term_end(code, match.end())
        if end > 0:
            yield match.start() - 1, end, "term", ""
    for match in re.finditer(r"(?<= )([+-])=(?=[ \n])", code):
        yield match.start(), match.end(), "sign", "-=" if match.group() == "+=" else "+="
    for match in re.finditer(r"(?:(?<=[(,=?:] )|(?<=\()|(?<=return ))-(?=[A-Za-z_(])", code):
        yield match.start(), match.end(), "sign", ""


def is_balanced(code):
    return all(code.count(a) == code.count(b) for a, b in ("()", "[]"))


def terms(code):
    for match in re.finditer(r"[;{})\n][ \n]+(\*?[A-Za-z_][^;{}\"=]*?) ([+*/-])=[ \n][^;{}\"]*;", code):
        if is_balanced(match.group(1)) and is_balanced(code[match.start(1):match.end()]):
            yield match.start(1), match.end(), "term" if match.group(2) in "+-" else "factor", ";"


def factors(code):
    for match in re.finditer(r"(?<=[\w)\]}@]) ([*/])(?=[ \n])", code):
        end = primary_end(code, match.end())
        if end > 0:
            yield match.start(), end, "factor", ""
    for match in re.finditer(r"(?<![\w.@])(\d+\.\d*|\d+)(?![\w.'@])", code):
        number = match.group()
        if re.search(r"\d[eE][-+]$", code[max(0, match.start() - 4):match.start()]):
            continue  # an exponent: numbers written with one are mostly tolerances
        if "." in number:
            value = float(number)
            if value:
                yield match.start(), match.end(), "factor", repr(2 * value)
        elif re.search(r"[*/] $", code[:match.start()][-2:]) or re.match(r" [*/] ", code[match.end():match.end() + 3]):
            if int(number):
                yield match.start(), match.end(), "factor", str(2 * int(number))


def indices(code):
    for match in re.finditer(r"(\w+)\((\w), (\w)\)", code):
        name, a, b = match.groups()
        if a != b and name not in SYMMETRIC:
            yield match.start(2), match.end(3), "index", f"{b}, {a}"
    for match in re.finditer(r"(?<=[\w)\]]\[)([012])(?=\])", code):
        yield match.start(), match.end(), "index", {"0": "1", "1": "0", "2": "1"}[match.group()]


OTHER = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==", "&&": "||", "||": "&&"}


def conditions(code):
    for match in re.finditer(r"(?<= )(<=|>=|==|!=|&&|\|\||<|>)(?=[ \n])", code):
        line = code_line(code, match.start())
        in_loop = match.group() == "<" and re.match(r" *for \(", line)
        # one too many would be an access behind the end, which is for the sanitizers: the loop leaves out its last
        yield match.start(), match.end(), "condition", "+ 1 <" if in_loop else OTHER[match.group()]
    for match in re.finditer(r"\bif \(", code):
        start = match.end() - 1
        end = closing(code, start)
        if end > 0 and ";" not in code[start:end]:
            yield start + 1, end, "condition", None


def returns(code):
    for match in re.finditer(r"\breturn ([^;{}\"]+);", code):
        value = match.group(1).strip()
        if value in ("nullptr", "std::nullopt", "*this") or "[" == value[0]:
            continue
        yield match.start(1), match.end(1), "return", {"true": "false", "false": "true", "0": "1"}.get(value, "{}")


def statement(code, start, end):
    """What is around a site: the condition that it is in, else the code between the nearest of ; { }."""
    first = max(code.rfind(c, 0, start) for c in ";{}") + 1
    last = min(place for place in (code.find(c, end) for c in ";{}") if place >= 0) if re.search(
        "[;{}]", code[end:]) else len(code)
    for match in re.finditer(r"\b(?:if(?: constexpr)?|while) \(", code[first:last]):
        opening = first + match.end() - 1
        close = closing(code, opening)
        if opening < start and end <= close:
            return code[opening:close]
        if close < start:
            first = close + 1
    return code[first:last]


def sites_of(path, text):
    code = code_of(text)
    seen = set()
    for find in (signs, terms, factors, indices, conditions, returns):
        for start, end, kind, new in find(code):
            around = statement(code, start, end)
            if NOT_A_FORMULA.search(around) or "{" in code[start:end].replace("{}", "") or HIDDEN == code[start]:
                continue
            if new is None:
                new = f"!({text[start:end]})"
            if (start, end, new) not in seen:
                seen.add((start, end, new))
                yield Site(path, start, end, kind, new)


def includes(tree, path, cache):
    if path not in cache:
        with open(os.path.join(tree, path), encoding="utf-8") as file:
            cache[path] = [p for p in re.findall(r'^#include "([^"]+)"', file.read(), re.M) if os.path.exists(os.path.join(tree, p))]
    return cache[path]


def reached_by(tree, folders=("framework", "components", "tools", "tests")):
    """For each file how many sources include it, directly or through others."""
    cache, count = {}, {}
    for folder in folders:
        for where, _, names in os.walk(os.path.join(tree, folder)):
            for name in names:
                if not name.endswith(".cpp"):
                    continue
                todo, seen = [os.path.relpath(os.path.join(where, name), tree)], set()
                while todo:
                    path = todo.pop()
                    if path not in seen:
                        seen.add(path)
                        todo += includes(tree, path, cache)
                for path in seen:
                    count[path] = count.get(path, 0) + 1
    return count


def weight(site, text, reached):
    value = next((w for folder, w in FOLDERS if site.path.startswith(folder)), 0)
    if FORMULA.search(code_line(text, site.start)):
        value *= 3
    if site.path.startswith("framework/") and site.path.endswith(".h"):
        value *= min(1, MOST_TEXT / reached.get(site.path, 1))
    return value


def code_line(text, at):
    return text[text.rfind("\n", 0, at) + 1:text.find("\n", at)]


def choose(tree, seed):
    """All sites of the tree in the order in which they are tried, with the texts they are in. Two sites of one line are
    never both tried; kinds come in the shares of KINDS."""
    reached = reached_by(tree)
    texts, found = {}, []
    for folder in ("framework", "components"):
        for where, inner, names in os.walk(os.path.join(tree, folder)):
            inner.sort()
            for name in sorted(names):
                path = os.path.relpath(os.path.join(where, name), tree).replace(os.sep, "/")
                if not name.endswith((".h", ".cpp")):
                    continue
                with open(os.path.join(tree, path), encoding="utf-8") as file:
                    texts[path] = file.read()
                found += [(site, weight(site, texts[path], reached)) for site in sites_of(path, texts[path])]
    total = {kind: sum(w for site, w in found if site.kind == kind) for kind in KINDS}
    numbers = random.Random(seed)
    keyed = []
    for site, w in found:
        u = numbers.random()  # one for each, so that an order depends on nothing else
        if w > 0:
            # the largest u^(1/w) first (Efraimidis and Spirakis 2006): a weighted draw without replacement
            keyed.append((-math.log(1 - u) * total[site.kind] / (w * KINDS[site.kind]), site))
    keyed.sort(key=lambda one: one[0])
    lines, order = set(), []
    for _, site in keyed:
        place = (site.path, site.line(texts[site.path]))
        if place not in lines:
            lines.add(place)
            order.append(site)
    return order, texts
