# SPDX-License-Identifier: LGPL-2.1-or-later
"""A page per component, from what `stroma doc --all --json` says, and a page that lists them by family."""
import os
import re

from repository_links import slug

FAMILIES = {  # module: title; a module that is not here is called by its name
    "mechanics": "Bodies and masses",
    "integrators": "Implicit time steps and statics",
    "further_integrators": "Explicit and further time steps",
    "iterative_solvers": "Iterative linear solvers",
    "preconditioned_solvers": "Preconditioned and automatic linear solvers",
    "direct_solvers": "Direct linear solvers",
    "elasticity": "Elastic tetrahedra",
    "further_elasticity": "Elastic hexahedra, quadratic cells and membranes",
    "hyperelasticity": "Hyperelastic, viscous and porous tissue",
    "diffusion": "Diffusion",
    "shape_memory": "Shape memory, fibres and actuators",
    "springs": "Springs",
    "beams": "Beams and joints",
    "condensation": "Condensed bodies",
    "loads": "Loads",
    "further_loads": "Further pressures, and penalty fields of planes and bodies",
    "formulas": "Loads by formulas",
    "constraints": "Held, moved and tied nodes",
    "position_constraints": "Kept volumes, planes and rigid sets",
    "mappings": "Mappings",
    "topology": "Meshes and cells",
    "further_topology": "Further meshes: other files, shapes, and cells made of others",
    "vtk_io": "VTK's file formats",
    "selection": "Regions of interest, and values by labels",
    "engines": "Engines: tables of points, meshes and numbers",
    "output": "Outputs",
}
SPECIAL = re.compile(r"([\\`*_\[\]<>|#])")


def title_of(module):
    """The heading of a family."""
    return FAMILIES.get(module, module.replace("_", " ").capitalize())


def folder_of(module):
    """Where its pages are in the site."""
    return "components/" + module


class ComponentPages:
    """`components` as `stroma doc --all --json` prints them; `scenes`: path of a scene -> its text;
    `tabs`: puts Python beside examples."""

    def __init__(self, components, scenes, repository, tabs):
        self.components = sorted(components, key=lambda component: component["name"].lower())
        self.repository, self.tabs = repository, tabs
        repository.components.update({c["name"]: f"{folder_of(c['module'])}/{c['name']}.md" for c in self.components})
        self.users = {c["name"]: [path for path, text in scenes.items() if re.search(rf"<{c['name']}[\s/>]", text)]
                      for c in self.components}

    def families(self):
        """Modules in the order of FAMILIES, then others, each with its components."""
        modules = {component["module"] for component in self.components}
        order = [m for m in FAMILIES if m in modules] + sorted(modules - set(FAMILIES))
        return [(m, [c for c in self.components if c["module"] == m]) for m in order]

    def nav(self):
        """The part of the navigation."""
        return ["components/README.md"] + [{title_of(module): [{c["name"]: self.repository.components[c["name"]]} for c in those]}
                                           for module, those in self.families()]

    def write(self):
        """All pages into the repository's pages."""
        self.repository.pages["components/README.md"] = self.index()
        for component in self.components:
            self.repository.pages[self.repository.components[component["name"]]] = self.page(component)

    def index(self):
        """The list of all components."""
        lines = ["# Components", "",
                 f"The {len(self.components)} components that a scene can name, by family. Each page has formulas, source, an example, "
                 "and every attribute with unit, default and range. `stroma doc NAME` prints the same.", ""]
        for module, those in self.families():
            lines += [f"## {title_of(module)}", "", "| | |", "|---|---|"]
            for component in those:
                target = self.repository.relative(self.repository.components[component["name"]], "components/README.md")
                lines.append(f"| [`{component['name']}`]({target}) | {escaped(component['help'])} |")
            lines.append("")
        return "\n".join(lines)

    def page(self, component):
        """One component."""
        site = self.repository.components[component["name"]]
        family = self.repository.relative("components/README.md#" + slug(title_of(component["module"])), site)
        name = re.sub(r"(?<=[a-z])(?=[A-Z])", "<wbr>", component["name"])  # where a narrow window may break it
        lines = [f"# {name}", "", sentence(component["help"]), "",
                 f"<small>Family [{title_of(component['module'])}]({family}) · role {component['role']} · "
                 f"module `{component['module']}`</small>", ""]
        prose, example = split_manual(component.get("manual") or "")
        lines += self.manual(prose, component, site)
        if example:
            lines += ["## Example", "", *self.tabs.of(example), ""]
        lines += attribute_table("Attributes", component.get("attributes") or [])
        if component.get("shorthands"):
            lines += ["SOFA's shorthands are taken too: " + ", ".join(f"`{name}`" for name in component["shorthands"]) + ".", ""]
        if component.get("visual_only"):
            lines += ["Accepted and without effect, because they only draw: "
                      + ", ".join(f"`{name}`" for name in component["visual_only"]) + ".", ""]
        lines += attribute_table("Outputs", component.get("outputs") or [])
        users = self.users[component["name"]]
        if users:
            lines += ["## Scenes with it", "", " · ".join(
                f"[{os.path.basename(path)}]({self.repository.relative(self.repository.place(path), site)})" for path in users), ""]
        return "\n".join(lines)

    def manual(self, text, component, site):
        """The comment of the source as Markdown: prose is escaped, what is indented is a formula and stays as it is."""
        lines, formula = [], []
        names = {a["name"] for a in (component.get("attributes") or []) + (component.get("outputs") or [])}

        def close():
            if formula:
                margin = min(len(line) - len(line.lstrip()) for line in formula if line.strip())
                lines.extend(["", "```text", *(line[margin:].rstrip() for line in formula), "```", ""])
                formula.clear()

        for line in text.split("\n"):
            if line.startswith("  "):
                formula.append(line)
            else:
                close()
                lines.append(self.prose(line, names, component["name"], site))
        close()
        return lines + [""]

    def prose(self, line, names, own, site):
        """A line of the comment; attributes are set as code, other components are links."""
        def word(match):
            name = match.group(0)
            target = self.repository.components.get(name)
            if target and name != own:
                return f"[`{name}`]({self.repository.relative(target, site)})"
            if name == own or (name in names and re.search(r"[a-z][A-Z]|_", name)):
                return f"`{name}`"
            return escaped(name)

        def piece(text):
            if text.startswith("`") or '="' in text:
                return "`" + text.strip("`") + "`"
            return re.sub(r"\w+", word, text) if re.match(r"\w", text) else escaped(text)

        out = "".join(piece(text) for text in re.findall(r'`[^`]+`|\w+="[^"]*"|\w+|[^\w`]+|`', line))
        return re.sub(r"^(Source|Sources):", r"**\1:**", out)


def split_manual(text):
    """(prose, example) of a manual page."""
    prose, mark, example = text.partition("\nExample:\n")
    if not mark:
        return text.strip("\n"), ""
    lines = [line for line in example.split("\n")]
    margin = min((len(line) - len(line.lstrip()) for line in lines if line.strip()), default=0)
    return prose.strip("\n"), "\n".join(line[margin:].rstrip() for line in lines).strip("\n")


def escaped(text):
    """Text without anything that Markdown would take as a sign."""
    return SPECIAL.sub(r"\\\1", text).replace("\\<", "&lt;").replace("\\>", "&gt;")


def sentence(text):
    """With a capital letter and a full stop."""
    text = escaped(text.strip())
    return text[:1].upper() + text[1:] + ("" if text.endswith((".", "!", "?")) else ".")


def default_of(data):
    """What a scene gets that does not name the attribute."""
    if data.get("required"):
        return "**required**"
    value = data.get("default")
    if value in (None, "", [], {}):
        return ""
    text = value if isinstance(value, str) else ("true" if value is True else "false" if value is False else str(value))
    text = text if len(text) <= 40 else text[:37] + "..."
    return f"`{text}`"


def meaning_of(data):
    """Help, and what else is worth knowing of an attribute."""
    parts = [sentence(data.get("help") or data["name"])]
    if data.get("choices"):
        parts.append("One of " + ", ".join(f"`{choice}`" for choice in data["choices"]) + ".")
    if data.get("range"):
        parts.append(f"In `{data['range']}`.")
    if data.get("aliases"):
        parts.append("Also called " + ", ".join(f"`{alias}`" for alias in data["aliases"]) + ".")
    if data.get("physical"):
        parts.append("The default is used with a warning.")
    if data.get("changes") in ("at once", "recompile"):  # else the scene has to be loaded again
        parts.append("May change in a run.")
    return " ".join(parts)


def attribute_table(heading, table):
    """The rows of attributes or outputs."""
    if not table:
        return []
    is_output = heading == "Outputs"
    lines = [f"## {heading}", "", "| Name | Type | Unit |" + ("" if is_output else " Default |") + " Meaning |",
             "|---|---|---|" + ("" if is_output else "---|") + "---|"]
    for data in table:
        unit = data.get("unit") or ""
        cells = [f"`{data['name']}`", "word" if data.get("choices") else escaped(data.get("type") or ""), escaped("" if unit == "-" else unit)]
        cells += [] if is_output else [default_of(data)]
        lines.append("| " + " | ".join([*cells, meaning_of(data)]) + " |")
    return lines + [""]
