#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Makes small wrong changes in the engine and its components, one at a time, and counts how many of them a test notices.

  tests/mutants/mutate.py --work build/mutants --count 300 --seed 1        the whole measurement, some hours
  tests/mutants/mutate.py --work build/mutants --count 300 --resume        goes on where it stopped
  tests/mutants/mutate.py --work build/mutants --only 'components/springs/*' --count 20 --minutes 15
  tests/mutants/mutate.py --list --count 40                                what would be changed; builds nothing

A change is a sign, a factor, a dropped term, a swapped index, a condition or a returned value, in code: not in messages,
includes, assertions, or what only declares. A seed chooses them, weighted towards formulas; a header of the framework
that many sources include is chosen less often, as it builds them all. The tree is copied to the work folder and built
there; the tree itself is never touched. Tests that are likely to notice a change run first, up to the first that fails;
a test that does not end counts as one that fails. What is not noticed after --first seconds of tests waits until there
are --group of its kind, which are then made together and get the rest of the tests; a group that is noticed is halved.
So what survives has survived all tests that open its module.

A change that does not compile, or leaves the same object code, is replaced by the next. Changes that were proved
harmless are listed with the reason in the file `harmless` beside this script. The record, WORK/record.jsonl, has a line
for each change. Exit codes: 0 enough were noticed, 1 fewer than --least, 2 wrong usage."""
import argparse
import collections
import fnmatch
import json
import os
import sys
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import sites  # noqa: E402
import trials  # noqa: E402

TREE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
COUNTED = ("noticed", "survived", "harmless")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--work", default=os.path.join(TREE, "build", "mutants"), help="folder of the copy and its build")
    parser.add_argument("--copy", help="where the copy lies, if not in WORK/tree")
    parser.add_argument("--seed", type=int, default=1, help="chooses the changes (default 1)")
    parser.add_argument("--count", type=int, default=300, help="how many changes count (default 300)")
    parser.add_argument("--only", action="append", default=[], metavar="GLOB", help="only files of this form; repeatable")
    parser.add_argument("--but", action="append", default=[], metavar="GLOB", help="no files of this form; repeatable")
    parser.add_argument("--at", action="append", default=[], metavar="FILE:LINE", help="all changes of this line instead")
    parser.add_argument("--list", action="store_true", help="print the changes and build nothing")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="compilers and tests at once")
    parser.add_argument("--minutes", type=float, help="begin no further change after so long")
    parser.add_argument("--resume", action="store_true", help="keep the record and try only what it does not have")
    parser.add_argument("--survivors", action="store_true", help="with --resume: try what survived once more")
    parser.add_argument("--first", type=float, default=60, help="seconds of tests for a change alone (default 60)")
    parser.add_argument("--without", metavar="REGEX", help="leave out tests of these names, to save their time")
    parser.add_argument("--group", type=int, default=8, help="changes that get the rest of the tests together (default 8)")
    parser.add_argument("--later", action="store_true", help="leave those that wait for another run with --resume")
    parser.add_argument("--least", type=float, default=0.95, help="share to be noticed (default 0.95)")
    parser.add_argument("--levels", default="x86-64-v4", help="instruction set that modules are built for")
    return parser.parse_args()


def say(text):
    print(time.strftime("%H:%M:%S ", time.gmtime()) + text, flush=True)


def read_harmless():
    """{(file, before, after): reason}; the file has blocks of four lines with blank lines between them."""
    known = {}
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "harmless"), encoding="utf-8") as file:
        blocks = file.read().split("\n\n")
    for block in blocks:
        lines = [line for line in block.split("\n") if line and not line.startswith("#")]
        if len(lines) == 4:
            known[lines[0].strip(), lines[1].strip(), lines[2].strip()] = lines[3].strip()
        elif lines:
            sys.exit(f"harmless: expected file, line before, line after and reason, found:\n{block}")
    return known


def summary(records, least):
    """The tables by kind and by folder; the share of what is counted."""
    def table(title, key):
        print(f"\n{title:32}{'noticed':>9}{'survived':>9}{'harmless':>9}{'share':>8}")
        rows = collections.defaultdict(collections.Counter)
        for record in records:
            if record["verdict"] in COUNTED:
                rows[key(record)][record["verdict"]] += 1
        total = sum(rows.values(), collections.Counter())
        for name, row in [*sorted(rows.items()), ("all", total)]:
            judged = row["noticed"] + row["survived"]
            share = f"{row['noticed'] / judged:7.1%}" if judged else "      -"
            print(f"{name:32}" + "".join(f"{row[verdict]:9}" for verdict in COUNTED) + " " + share)
        return total

    table("kind", lambda record: record["kind"])
    total = table("folder", lambda record: "/".join(record["file"].split("/")[:2]))
    verdicts = collections.Counter(record["verdict"] for record in records)
    bits = sum(1 for record in records if record["verdict"] == "noticed" and "project.bits" in record["by"])
    print(f"\nmade {len(records)}; not compiled {verdicts['does not compile']}; same object code {verdicts['same code']}; "
          f"noticed by stored bits alone {bits}")
    if verdicts["pending"]:
        print(f"{verdicts['pending']} wait for the rest of the tests: --resume")
    for record in records:
        if record["verdict"] in ("survived", "pending"):
            print(f"{record['verdict']}: {record['file']}:{record['line']} ({record['kind']})\n"
                  f"  {record['before']}\n  {record['after']}")
    judged = total["noticed"] + total["survived"]
    share = total["noticed"] / judged if judged else 0
    print(f"{total['noticed']} of {judged} noticed: {share:.1%} (at least {least:.0%} wanted)")
    return share


def chosen(args):
    if not args.at:
        order, texts = sites.choose(TREE, args.seed)
        def matches(site, globs):
            return any(fnmatch.fnmatch(site.path, glob) for glob in globs)
        return [site for site in order if (not args.only or matches(site, args.only)) and not matches(site, args.but)], texts
    order, texts = [], {}
    for place in args.at:
        path, line = place.rsplit(":", 1)
        with open(os.path.join(TREE, path), encoding="utf-8") as file:
            texts[path] = file.read()
        order += [site for site in sites.sites_of(path, texts[path]) if site.line(texts[path]) == int(line)]
    return order, texts


def identity(record):
    return record["file"], record["before"], record["after"]


class Record:
    """The verdicts, also in a file with one JSON object for each line; of two for one change the later one counts."""

    def __init__(self, args):
        self.path, self.all = os.path.join(args.work, "record.jsonl"), {}
        if args.resume and os.path.exists(self.path):
            with open(self.path, encoding="utf-8") as file:
                self.all = {identity(record): record for record in map(json.loads, file)}
            if args.survivors:
                self.all = {key: record for key, record in self.all.items() if record["verdict"] != "survived"}
        for key, reason in read_harmless().items():  # what was proved since
            if key in self.all and self.all[key]["verdict"] in ("survived", "pending"):
                self.all[key].update(verdict="harmless", by=reason)
        with open(self.path, "w", encoding="utf-8") as file:
            file.writelines(json.dumps(record) + "\n" for record in self.all.values())

    def add(self, record):
        self.all[identity(record)] = record
        with open(self.path, "a", encoding="utf-8") as file:
            file.write(json.dumps(record) + "\n")
        by = f": {record['by']}" if record["by"] else ""
        say(f"{self.counted()} {record['verdict']} {record['seconds']} s {record['file']}:{record['line']} "
            f"({record['kind']}){by}")

    def counted(self):
        return sum(1 for record in self.all.values() if record["verdict"] in COUNTED + ("pending",))


def judge(work, waiting, texts, record):
    """The rest of the tests for changes that were not noticed: (record, site) pairs."""
    start = time.time()
    verdict, by, passed = work.try_group([site for _, site in waiting], texts, [r["passed"] for r, _ in waiting])
    seconds = round((time.time() - start) / len(waiting), 1)
    say(f"{len(waiting)} together: {verdict} {by}")
    for entry, _ in waiting:
        entry["seconds"] = round(entry["seconds"] + seconds, 1)
    if verdict == "survived" or len(waiting) == 1:
        for entry, _ in waiting:
            entry.update(verdict=verdict, by=by, passed=[])
            record.add(entry)
        return
    half = len(waiting) // 2
    for entry, _ in waiting:
        entry["passed"] = sorted({*entry["passed"], *passed})
    judge(work, waiting[:half], texts, record)
    judge(work, waiting[half:], texts, record)


def run(args, order, texts):
    os.makedirs(args.work, exist_ok=True)
    record, harmless = Record(args), read_harmless()
    until = time.time() + 60 * args.minutes if args.minutes else float("inf")
    copy = args.copy or os.path.join(args.work, "tree")
    settings = [f"-DSTROMA_LEVELS={args.levels}"]
    if not os.path.isdir(os.path.join(os.path.dirname(os.path.abspath(copy)), "shared", "data")):
        settings.append("-DSTROMA_SHARED_DATA=" + os.path.join(os.path.dirname(TREE), "shared", "data"))  # the tree's own
    work = trials.Trials(TREE, args.work, copy, args.jobs, settings, args.without)
    work.prepare(say)
    work.measure(say)
    waiting = []
    for site in order:
        if time.time() > until:
            break
        before, after = site.before_and_after(texts[site.path])
        entry = {"file": site.path, "line": site.line(texts[site.path]), "kind": site.kind, "before": before, "after": after}
        known = record.all.get(identity(entry))
        if known:
            if known["verdict"] == "pending":
                waiting.append((known, site))
        elif record.counted() < args.count:
            start = time.time()
            if identity(entry) in harmless:
                verdict, by, passed, work.build_seconds = "harmless", harmless[identity(entry)], [], 0
            else:
                verdict, by, passed = work.try_site(site, texts, args.first)
            entry.update(verdict=verdict, by=by, build_seconds=round(work.build_seconds, 1),
                         seconds=round(time.time() - start, 1), passed=passed if verdict == "pending" else [])
            record.add(entry)
            if verdict == "pending":
                waiting.append((entry, site))
        if len(waiting) >= args.group and not args.later:
            judge(work, waiting, texts, record)
            waiting = []
    if waiting and not args.later:
        judge(work, waiting, texts, record)
    return list(record.all.values())


def main():
    args = arguments()
    order, texts = chosen(args)
    if args.list:
        for site in order[:args.count]:
            before, after = site.before_and_after(texts[site.path])
            print(f"{site.path}:{site.line(texts[site.path])} ({site.kind})\n  {before}\n  {after}")
        return 0
    records = run(args, order, texts)
    return 0 if summary(records, args.least) >= args.least else 1


if __name__ == "__main__":
    sys.exit(main())
