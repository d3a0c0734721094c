# SPDX-License-Identifier: LGPL-2.1-or-later
"""The page of words that people search for, from the topics of `stroma doc`."""
import os

from component_pages import escaped

TOPICS = "tools/command/words/topics.txt"
FIELDS = ("also", "components", "commands", "pages")


def topics_of(text):
    """[{"name", "note", "text", "also", ...}] of the file of topics."""
    found = []
    for line in text.split("\n"):
        if not line.strip() or line.startswith("#"):
            continue
        if not line[0].isspace():
            name, _, note = line.partition(" (")
            found.append({"name": name.strip(), "note": note.rstrip(")"), "text": []})
            continue
        key, colon, value = line.strip().partition(":")
        if colon and key in FIELDS:
            found[-1][key] = value.strip()
        else:
            found[-1]["text"].append(line.strip())
    return found


def words_page(text, repository):
    """The page words.md."""
    lines = ["# Words people search for", "",
             "A word, what Stroma has for it, and where to read on. What is not there says so. `stroma doc WORD` prints the same, and "
             "`stroma list WORD` the components.", ""]
    for topic in sorted(topics_of(text), key=lambda topic: topic["name"].lower()):
        lines += [f"## {topic['name'][:1].upper() + topic['name'][1:]}", ""]
        note = f"**{topic['note'].capitalize()}.** " if topic["note"] else ""
        lines += [note + "\n".join(escaped(line) for line in topic["text"]), ""]
        names = [f"[`{name}`]({repository.components[name]})" for name in topic.get("components", "").split()
                 if name in repository.components]
        pages = [page_link(path, repository) for path in topic.get("pages", "").split()]
        commands = [f"[`stroma {name}`](command.md#stroma-{name})" for name in topic.get("commands", "").split()]
        if names or pages or commands:
            lines += [" · ".join(names + commands + pages), ""]
        if topic.get("also"):
            lines += [f"<small>Also searched as: {escaped(topic['also'])}</small>", ""]
    return "\n".join(lines)


def page_link(path, repository):
    """A link to a page of docs/, with its title."""
    with open(os.path.join(repository.root, path), encoding="utf-8") as file:
        title = next((line[2:].strip() for line in file if line.startswith("# ")), os.path.basename(path))
    return f"[{title}]({repository.relative(repository.place(path), 'words.md')})"
