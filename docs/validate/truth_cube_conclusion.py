# SPDX-License-Identifier: LGPL-2.1-or-later
"""The tables of the truth cube in words. Every number is read from their rows; a reason has a row that shows it."""
import truth_cube_paper as paper

BASE = "tets, polar, B"
NO_MODEL = "no model: the travel spread evenly, no bulge"
HEXES, GREEN = "hexes, polar, no B", "hexes, large deformation (Ansys)"
SMALL = "hexes, small deformation (Ansys)"
LOGARITHMIC = "hexes, logarithmic strain, mean dilatation"
LITTLE = 0.1  # points of the mean deviation
MEAN, REMARK = 2, -1  # columns of the tables
PRINTED = {row.name: [stage[0] for stage in row.printed] for row in paper.ROWS if row.printed}
SETTINGS = {False: "the paper's settings", True: "statics"}


def numbers(values):
    """As numbers, or None where one has no answer."""
    try:
        return [float(value) for value in values]
    except ValueError:
        return None


def means(rows, name):
    """Mean deviations of a method at the three compressions, or None."""
    return numbers([row[MEAN] for row in rows if row[0] == name]) or None


def listed(words, limit=6):
    words = list(words)
    shown = ", ".join(words[:limit])
    return (shown + f" and {len(words) - limit} more" if len(words) > limit else shown) or "none"


def quoted(name):
    """Names have commas of their own."""
    return f'"{name}"'


def spoken(values):
    return "no answer" if values is None else "{:.2f}, {:.2f} and {:.2f}".format(*values)


def told(phrases):
    """Phrases as sentences of their own."""
    return " ".join(phrase[:1].upper() + phrase[1:] + "." for phrase in phrases)


def apart(a, b):
    """Largest difference of two rows of numbers."""
    return max(abs(x - y) for x, y in zip(a, b))


def compared(tables, name, printed):
    """A phrase for each table: the means of a method, and how far they are from the printed ones."""
    for (poisson, static), rows in tables.items():
        if any(row[0] == name for row in rows):
            values = means(rows, name)
            off = f" (at most {apart(values, printed):.2f} off)" if values else ""
            yield f"{spoken(values)}{off} at {poisson} with {SETTINGS[static]}"


def what_moves(tables, varied):
    """The row with B by the polar method, and what brings it nearer to the paper's."""
    printed, base = PRINTED[BASE], numbers(varied[0][1:4])
    text = f"- **{BASE}**: {told(compared(tables, BASE, printed))} The paper prints {spoken(printed)}."
    if base is None:
        return text + "\n"
    groups = {"nearer": [], "farther": [], "little": []}
    for row in varied[1:]:
        values = numbers(row[1:4])
        if values and row[0] != NO_MODEL and not row[0].startswith(("hexes", "paper: ")):
            off = apart(values, printed)
            little = apart(values, base) < LITTLE
            groups["little" if little else "nearer" if off < apart(base, printed) else "farther"].append((off, row[0]))
    named = {key: listed(f"{quoted(name)} ({off:.2f})" for off, name in sorted(group)) for key, group in groups.items()}
    text += (f" In statics without gravity it is at most {apart(base, printed):.2f} off. Nearer to the paper come: {named['nearer']}. "
             f"Away from it go: {named['farther']}. Less than {LITTLE} points of change: {named['little']}.")
    return text + "\n"


def every_row(tables):
    """For each printed row how far ours are from it in each table of dynamics, and with QR's two labels exchanged."""
    columns = [key for key in tables if not key[1]]
    lines = ["| row of the paper | " + " | ".join(f"at {poisson}" for poisson, _ in columns) + " |",
             "|---" * (len(columns) + 1) + "|"]
    exchanged = {"tets, QR, no B": "tets, QR, B", "tets, QR, B": "tets, QR, no B"}
    for name, printed in PRINTED.items():
        for label, ours in [(name, name)] + [(f"{name}, against our {other}", other) for other in [exchanged.get(name)] if other]:
            cells = []
            for key in columns:
                values = means(tables[key], ours)
                remark = any(row[0] == ours and row[REMARK] for row in tables[key])
                present = any(row[0] == ours for row in tables[key])
                cells.append((f"{apart(values, printed):.2f}" + (" (with a remark)" if remark else "")) if values
                             else "no answer" if present else "")
            lines.append(f"| {label} | " + " | ".join(cells) + " |")
    near = [name for name, printed in PRINTED.items() if (values := means(tables[columns[-1]], name)) and apart(values, printed) < 0.05]
    return ("Every row with the paper's settings: the largest of the three differences of the mean, in points.\n\n" +
            "\n".join(lines) + f"\n\nAt {columns[-1][0]} {len(near)} of {len(PRINTED)} rows are within 0.05 of the paper's: "
            f"{listed((quoted(name) for name in near), 14)}. With an updated B they have no answer, or are farther off, at the printed "
            "0.499: the printed rows are of a cube that gives way in volume as one of the smaller ratio does.\n\n")


def unanswered(rows):
    """Methods without a number, or with a remark, at some compression; and the number of methods."""
    bad = {row[0]: None for row in rows if row[MEAN] == "-" or row[REMARK]}
    return list(bad), len({row[0] for row in rows})


def where_no_answer(tables):
    """How many rows have no answer in each table."""
    phrases = []
    for (poisson, static), rows in tables.items():
        bad, count = unanswered(rows)
        phrases.append(f"{len(bad)} of {count} at {poisson} with {SETTINGS[static]} ({listed((quoted(name) for name in bad), 14)})")
    text = "- **Rows without an answer, or with a remark**: " + told(phrases)
    text += (" At 0.499 lambda is 499 mu. The pressures of elements that lock act as a negative stiffness against turning them. "
             "The tables with a mean dilatation differ from the others in nothing but these pressures. They are the answer for a "
             "body that must be stable at 0.499.")
    return text + "\n"


def without_bulge(tables, varied):
    """The paper's hexahedra without B and Phymul against the field that has no bulge."""
    lines = {row[0]: numbers(row[1:6]) for row in varied}
    field, printed, free = (lines.get(name) for name in (NO_MODEL, "paper: " + HEXES, HEXES + ", Poisson's ratio 0"))
    text = f"- **{HEXES}**: " + told(compared(tables, HEXES, PRINTED[HEXES])) + " "
    text += (f"The paper's row (means {spoken(printed[:3])}, deviation {printed[3]:.2f}, largest {printed[4]:.2f}) is in all of "
             f"these at most {apart(field, printed):.2f} off the field without any bulge.")
    text += f" It is {apart(free, printed):.2f} off a run with a Poisson's ratio of 0.\n" if free else "\n"
    kept, ours = (next((values for rows in tables.values() if (values := means(rows, name))), None)
                  for name in ("Phymul", "Phymul, volume free"))
    text += f"- **Phymul**: {spoken(kept)} with its volume kept by a VolumeConstraint, {spoken(ours)} without"
    text += f", which is at most {apart(ours, field[:3]):.2f} off the field without bulge" if ours else ""
    text += f". The paper prints {spoken(PRINTED['Phymul'])}.\n"
    return text


def nearest(tables, printed):
    """Distance, name and table of the row whose means are nearest to the printed ones; None when no row has an answer."""
    found = [(apart(values, printed), name, poisson, SETTINGS[static]) for (poisson, static), rows in tables.items()
             for name in dict.fromkeys(row[0] for row in rows) if (values := means(rows, name))]
    return min(found, default=None)


def small_deformation(tables):
    return (f"- **{SMALL}**: " + told(compared(tables, SMALL, PRINTED[SMALL])) +
            f" The paper prints {spoken(PRINTED[SMALL])}.\n")


def large_deformation(tables, varied):
    text = f"- **{GREEN}**, Green's strain with Hooke's law: " + told(compared(tables, GREEN, PRINTED[GREEN]))
    text += f" The paper prints {spoken(PRINTED[GREEN])}."
    best = nearest(tables, PRINTED[GREEN])
    if best and best[1] != GREEN:
        text += " Nearest to it of all rows above is {1} at {2} with {3} (at most {0:.2f} off).".format(*best)
    logarithmic = next((row for row in varied if row[0] == LOGARITHMIC and row[1] != "-"), None)
    if logarithmic:
        found = numbers(logarithmic[1:4])
        text += (f" With the logarithmic strain in the place of Green's and one volume change per hexahedron it is {spoken(found)}, at most "
                 f"{apart(found, PRINTED[GREEN]):.2f} off. What differs is the measure of strain. Programs of engineers take it to "
                 "be the logarithmic one when they are given Young's modulus and large deformations. Hooke's law on Green's strain "
                 "softens in compression.")
    return text + "\n"


def conclusion(tables, varied):
    """`tables`: rows by (name in BODIES, statics or not); `varied`: rows of what is varied, the first unchanged."""
    finer = [row for row in varied if row[0].endswith("cells")]
    text = (every_row(tables) + "Read from the tables; \"off\" is the largest of the differences between two rows, in points; in brackets: off the "
            "paper.\n\n" +
            what_moves(tables, varied) + where_no_answer(tables) + without_bulge(tables, varied) +
            small_deformation(tables) + large_deformation(tables, varied))
    if finer:
        text += ("- **Cells**: " + told(f"{row[0]}: {spoken(numbers(row[1:4]))}" for row in finer) +
                 f" 8 x 8 x 8: {spoken(numbers(varied[0][1:4]))}.\n")
    return text
