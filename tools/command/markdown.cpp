// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/markdown.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <regex>
#include <sstream>

#include "framework/scene/text.h"

namespace stroma::command {
namespace {

using BlockKind = Block::Kind;

constexpr std::size_t text_width = 96, name_width = 30;

/// The cells of "| a | b |".
std::vector<std::string> cellsOf(std::string_view line) {
  std::vector<std::string> cells;
  line.remove_prefix(1);
  for (auto bar = line.find('|'); bar != std::string_view::npos; bar = line.find('|')) {
    cells.emplace_back(trimmed(line.substr(0, bar)));
    line.remove_prefix(bar + 1);
  }
  return cells;
}

bool isRule(const std::vector<std::string>& cells) {
  return std::ranges::all_of(cells, [](const std::string& cell) { return cell.find_first_not_of("-: ") == cell.npos; });
}

class Reader {
 public:
  std::vector<Block> read(std::string_view page) {
    std::istringstream in{std::string(page)};
    for (std::string line; std::getline(in, line);) take(line);
    return std::move(blocks_);
  }

 private:
  void take(const std::string& line) {
    const std::string_view text = trimmed(line);
    if (text.starts_with("```")) {
      if (!in_code_) add(BlockKind::code, "");
      in_code_ = !in_code_, goes_on_ = false;
    } else if (in_code_) {
      (blocks_.back().text += line) += '\n';
    } else if (text.empty() || text.starts_with("<!--")) {
      goes_on_ = false;
    } else if (text[0] == '#') {
      const auto level = text.find_first_not_of('#');
      add(BlockKind::heading, trimmed(text.substr(level))).level = int(level);
      goes_on_ = false;
    } else if (text[0] == '|') {
      if (!goes_on_ || blocks_.back().kind != BlockKind::table) add(BlockKind::table, "");
      if (auto cells = cellsOf(text); !isRule(cells) || blocks_.back().rows.empty())
        blocks_.back().rows.push_back(std::move(cells));
    } else if (text.starts_with("- ")) {
      add(BlockKind::item, text.substr(2));
    } else if (goes_on_) {
      (blocks_.back().text += ' ') += text;
    } else {
      add(BlockKind::paragraph, text);
    }
  }

  Block& add(BlockKind kind, std::string_view text) {
    blocks_.push_back({kind, 0, std::string(text), {}});
    goes_on_ = true;
    return blocks_.back();
  }

  std::vector<Block> blocks_;
  bool in_code_ = false, goes_on_ = false;
};

/// Text with its code, bold words and links, each piece handed to `piece(text, is_set_off)`.
template <class Piece>
std::string inlined(const std::string& text, Piece&& piece) {
  static const std::regex marks(R"(`([^`]+)`|\*\*([^*]+)\*\*|\[([^\]]+)\]\([^)]+\))");
  std::string out;
  auto rest = text.cbegin();
  for (std::sregex_iterator at(text.begin(), text.end(), marks), end; at != end; ++at) {
    out += piece(std::string(rest, text.cbegin() + at->position()), false);
    for (std::size_t group = 1; group <= 3; ++group)
      if ((*at)[group].matched) {
        std::string inner = (*at)[group].str();
        if (group > 1) std::erase(inner, '`');
        out += piece(inner, group < 3);
      }
    rest = text.cbegin() + at->position() + at->length();
  }
  return out + piece(std::string(rest, text.cend()), false);
}

std::string plain(const std::string& text) {
  return inlined(text, [](const std::string& piece, bool) { return piece; });
}

/// Lines of at most text_width characters; those after the first start with `indent` blanks.
std::string wrapped(const std::string& text, std::size_t indent, std::size_t used) {
  std::istringstream in(text);
  std::string out;
  std::size_t column = used;
  for (std::string word; in >> word;) {
    if (column > indent && column + 1 + word.size() > text_width) {
      (out += '\n').append(indent, ' ');
      column = indent;
    } else if (!out.empty()) {
      out += ' ', ++column;
    }
    out += word, column += word.size();
  }
  return out;
}

std::string rowText(const std::vector<std::string>& row) {
  const std::string name = row.empty() ? "" : plain(row[0]);
  std::string rest;
  for (std::size_t i = 1; i < row.size(); ++i) (rest += i > 1 ? "; " : "") += plain(row[i]);
  const std::size_t indent = name_width + 4;
  const bool fits = name.size() <= name_width;
  std::string out = "  " + name;
  if (fits)
    out.append(indent - out.size(), ' ');
  else
    (out += '\n').append(indent, ' ');
  return out + wrapped(rest, indent, indent) + "\n";
}

std::string set(const std::string& piece, bool is_set_off) {
  if (piece.empty()) return "";
  return is_set_off ? "\\fB" + escaped(piece) + "\\fP" : escaped(piece);
}
std::string setText(const std::string& text) { return brokenForTroff(inlined(text, set)); }

std::string manTable(const Block& block) {
  std::string out;
  for (std::size_t i = 1; i < block.rows.size(); ++i) {
    std::string rest;
    for (std::size_t k = 1; k < block.rows[i].size(); ++k) (rest += k > 1 ? "; " : "") += setText(block.rows[i][k]);
    out += ".TP\n" + setText(block.rows[i][0]) + "\n" + rest + "\n";
  }
  return out;
}

}  // namespace

std::vector<Block> readMarkdown(std::string_view page) { return Reader().read(page); }

std::string asText(const std::vector<Block>& blocks) {
  std::string out;
  for (const Block& block : blocks) {
    if (!out.empty() && block.kind != BlockKind::item) out += '\n';
    if (block.kind == BlockKind::heading) {
      out += plain(block.text) + "\n" + std::string(plain(block.text).size(), block.level > 1 ? '-' : '=') + "\n";
    } else if (block.kind == BlockKind::code) {
      std::istringstream in(block.text);
      for (std::string line; std::getline(in, line);) out += line.empty() ? "\n" : "    " + line + "\n";
    } else if (block.kind == BlockKind::table) {
      for (std::size_t i = 1; i < block.rows.size(); ++i) out += rowText(block.rows[i]);
    } else {
      const bool is_item = block.kind == BlockKind::item;
      out += (is_item ? "- " : "") + wrapped(plain(block.text), is_item ? 2 : 0, is_item ? 2 : 0) + "\n";
    }
  }
  return out;
}

std::string brokenForTroff(const std::string& text) {
  std::istringstream in(text);
  std::string out;
  std::size_t column = 0;
  for (std::string word; in >> word;) {
    const bool starts_line = out.empty() || column + word.size() > 70;
    if (!out.empty()) out += starts_line ? '\n' : ' ';
    if (starts_line && (word[0] == '.' || word[0] == '\'')) out += "\\&";
    out += word;
    column = (starts_line ? 0 : column + 1) + word.size();
  }
  return out;
}

std::string escaped(std::string_view text) {
  std::string out;
  bool starts_line = true;
  for (const char letter : text) {
    if (starts_line && letter == '.') out += "\\&";
    switch (letter) {
      case '\\':
        out += "\\e";
        break;
      case '-':
        out += "\\-";
        break;
      case '\'':
        out += "\\(aq";
        break;
      case '`':
        out += "\\(ga";
        break;
      case '^':
        out += "\\(ha";
        break;
      case '~':
        out += "\\(ti";
        break;
      default:
        out += letter;
    }
    starts_line = letter == '\n';
  }
  return out;
}

std::string asMan(const std::vector<Block>& blocks) {
  std::string out;
  bool starts_section = true;
  for (const Block& block : blocks) {
    if (block.kind == BlockKind::heading && block.level == 1) continue;
    if (block.kind == BlockKind::heading) {
      std::string title = block.text;
      if (block.level == 2)
        std::ranges::transform(title, title.begin(), [](unsigned char c) { return std::toupper(c); });
      out += fmt::format("{} {}\n", block.level == 2 ? ".SH" : ".SS", escaped(title));
    } else if (block.kind == BlockKind::code) {
      (out += starts_section ? "" : ".PP\n") += ".RS 4\n.nf\n" + escaped(block.text) + ".fi\n.RE\n";
    } else if (block.kind == BlockKind::table) {
      out += manTable(block);
    } else if (block.kind == BlockKind::item) {
      out += ".IP \\(bu 2\n" + setText(block.text) + "\n";
    } else {
      out += (starts_section ? "" : ".PP\n") + setText(block.text) + "\n";
    }
    starts_section = block.kind == BlockKind::heading;
  }
  return out;
}

}  // namespace stroma::command
