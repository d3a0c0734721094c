#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Makes small wrong changes in the engine and its components, one at a time, and counts how many of them a test notices.

  tools/mutants/mutate.py --work build/mutants --count 300 --seed 1        the whole measurement, some hours
  tools/mutants/mutate.py --work build/mutants --count 300 --resume        goes on where it stopped
  tools/mutants/mutate.py --work build/mutants --only 'components/springs/*' --count 20 --minutes 15
  tools/mutants/mutate.py --list --count 40                                what would be changed; builds nothing

A change is a sign, a factor, a dropped term, a swapped index, a condition or a returned value, in code: not in messages,
includes, assertions, or what only declares. A seed chooses them, weighted towards formulas; a header of the framework
that many sources include is chosen less often, as it builds them all. The tree is copied to the work folder and built
there; the tree itself is never touched. Tests that are likely to notice a change run first, up to the first that fails;
a test that does not end counts as one that fails. What no test notices has survived all tests that open its module.

A change that does not compile, or leaves the same object code, is replaced by the next. Changes that were proved
harmless are listed with the reason in the file `harmless` beside this script. The record, WORK/record.jsonl, has a line
for each change. Exit codes: 0 enough were noticed, 1 fewer than --least, 2 wrong usage."""
import argparse
import collections
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
    parser.add_argument("--seed", type=int, default=1, help="chooses the changes (default 1)")
    parser.add_argument("--count", type=int, default=300, help="how many changes count (default 300)")
    parser.add_argument("--only", action="append", default=[], metavar="GLOB", help="only files of this form; repeatable")
    parser.add_argument("--at", action="append", default=[], metavar="FILE:LINE", help="all changes of this line instead")
    parser.add_argument("--list", action="store_true", help="print the changes and build nothing")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="compilers and tests at once")
    parser.add_argument("--minutes", type=float, help="begin no further change after so long")
    parser.add_argument("--resume", action="store_true", help="keep the record and try only what it does not have")
    parser.add_argument("--survivors", action="store_true", help="with --resume: try what survived once more")
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
    for record in records:
        if record["verdict"] == "survived":
            print(f"survived: {record['file']}:{record['line']} ({record['kind']})\n"
                  f"  {record['before']}\n  {record['after']}")
    judged = total["noticed"] + total["survived"]
    share = total["noticed"] / judged if judged else 0
    print(f"{total['noticed']} of {judged} noticed: {share:.1%} (at least {least:.0%} wanted)")
    return share


def chosen(args):
    if not args.at:
        return sites.choose(TREE, args.seed, args.only)
    order, texts = [], {}
    for place in args.at:
        path, line = place.rsplit(":", 1)
        with open(os.path.join(TREE, path), encoding="utf-8") as file:
            texts[path] = file.read()
        order += [site for site in sites.sites_of(path, texts[path]) if site.line(texts[path]) == int(line)]
    return order, texts


def open_record(args, path):
    records = []
    if args.resume and os.path.exists(path):
        with open(path, encoding="utf-8") as file:
            records = [json.loads(line) for line in file]
        if args.survivors:
            records = [record for record in records if record["verdict"] != "survived"]
    with open(path, "w", encoding="utf-8") as file:
        file.writelines(json.dumps(record) + "\n" for record in records)
    return records


def identity(record):
    return record["file"], record["before"], record["after"]


def run(args, order, texts):
    os.makedirs(args.work, exist_ok=True)
    path = os.path.join(args.work, "record.jsonl")
    records = open_record(args, path)
    done, harmless = {identity(record) for record in records}, read_harmless()
    for record in records:  # what was proved since
        if record["verdict"] == "survived" and identity(record) in harmless:
            record["verdict"], record["by"] = "harmless", harmless[identity(record)]
    until = time.time() + 60 * args.minutes if args.minutes else float("inf")
    data = os.path.join(os.path.dirname(TREE), "shared", "data")  # where the tree's own tests look
    work = trials.Trials(TREE, args.work, args.jobs, [f"-DSTROMA_LEVELS={args.levels}", f"-DSTROMA_SHARED_DATA={data}"])
    work.prepare(say)
    work.measure(say)
    for site in order:
        counted = sum(1 for record in records if record["verdict"] in COUNTED)
        if counted >= args.count or time.time() > until:
            break
        before, after = site.before_and_after(texts[site.path])
        record = {"file": site.path, "line": site.line(texts[site.path]), "kind": site.kind, "before": before, "after": after}
        if identity(record) in done:
            continue
        start = time.time()
        if identity(record) in harmless:
            verdict, by, built = "harmless", harmless[identity(record)], 0
        else:
            verdict, by, built = work.try_site(site, texts[site.path])
        record.update(verdict=verdict, by=by, build_seconds=round(built, 1), seconds=round(time.time() - start, 1))
        records.append(record)
        with open(path, "a", encoding="utf-8") as file:
            file.write(json.dumps(record) + "\n")
        say(f"{counted + (verdict in COUNTED)}/{args.count} {verdict} {record['seconds']} s {site.path}:{record['line']} "
            f"({site.kind}){': ' + by if by else ''}")
    return records


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
