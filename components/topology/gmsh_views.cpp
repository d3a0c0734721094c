// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/topology/gmsh_views.h"

namespace stroma {

/// Names, times and numbers, always as text.
GmshViews::Header GmshViews::readHeader(GmshCursor& in) {
  Header header;
  const auto names = in.checkCount(in.textNumber<std::int64_t>("the number of a view's names"), 1, "names of a view");
  in.line();
  for (std::size_t i = 0; i < names; ++i) {
    const std::string_view text = in.line();
    const std::size_t first = text.find('"'), last = text.rfind('"');
    if (i == 0) header.name = first == last ? text : text.substr(first + 1, last - first - 1);
  }
  const auto times = in.checkCount(in.textNumber<std::int64_t>("the number of a view's times"), 2, "times of a view");
  for (std::size_t i = 0; i < times; ++i) in.textNumber<double>("a view's time");
  const auto whole = in.checkCount(in.textNumber<std::int64_t>("the number of a view's counts"), 2, "counts of a view");
  for (std::size_t i = 0; i < whole; ++i) {
    const auto value = in.textNumber<std::int64_t>("a view's count");
    if (i < 3) header.count[i] = value;
  }
  return header;
}

bool GmshViews::read(bool of_nodes, bool binary, GmshCursor& in, const GmshTags& nodes,
                     std::map<std::string, GmshData>& all) {
  const Header header = readHeader(in);
  if (header.count[1] != 1 && header.count[1] != 3 && header.count[1] != 9) return false;
  const std::size_t width = std::size_t(header.count[1]);
  const auto entries = in.checkCount(header.count[2], 2 * (width + 1), "entries of a view");
  if (binary) in.line();
  in.binary = binary;
  GmshData& data = all[header.name];
  prepare(of_nodes, width, nodes.size(), data);
  for (std::size_t i = 0; i < entries; ++i) {
    double* place = placeOf(of_nodes, in.number<int>("a view's entry"), in, nodes, data);
    for (std::size_t k = 0; k < width; ++k) {
      const double value = in.number<double>("a view's value");
      if (place) place[k] = value;
    }
  }
  in.binary = false;
  const std::string_view end = of_nodes ? "$EndNodeData" : "$EndElementData";
  if (const std::string_view found = in.word(); found != end)
    in.fail(fmt::format("'{}' where the view should end", found.substr(0, 40)), std::string(end));
  return true;
}

/// Zeros for every node, or for every cell; of a view that comes again the first is kept.
void GmshViews::prepare(bool of_nodes, std::size_t width, std::size_t nodes, GmshData& data) {
  bool seen = of_nodes && !data.nodes.empty();
  for (const std::vector<double>& values : data.cells) seen = seen || (!of_nodes && !values.empty());
  data.repeated = data.repeated || seen || (data.width != 0 && data.width != int(width));
  if (data.repeated) return;
  data.width = int(width);
  if (of_nodes) return data.nodes.assign(nodes * width, 0.);
  for (std::size_t kind = 0; kind < cell_types; ++kind) data.cells[kind].assign(cell_tags_[kind].size() * width, 0.);
  indexCells();
}

void GmshViews::indexCells() {
  if (!cell_of_tag_.empty()) return;
  for (std::size_t kind = 0; kind < cell_types; ++kind)
    for (std::size_t c = 0; c < cell_tags_[kind].size(); ++c) cell_of_tag_[cell_tags_[kind][c]] = {CellType(kind), c};
}

/// Where the values of a tag go; null where they are not wanted.
double* GmshViews::placeOf(bool of_nodes, std::int64_t tag, const GmshCursor& in, const GmshTags& nodes,
                           GmshData& data) const {
  if (data.repeated) return nullptr;
  const std::size_t width = std::size_t(data.width);
  if (of_nodes) return &data.nodes[std::size_t(nodes.nodeOf(tag, in, "a view")) * width];
  const auto cell = cell_of_tag_.find(tag);
  if (cell == cell_of_tag_.end()) return nullptr;
  const auto& [type, number] = cell->second;
  return &data.cells[std::size_t(type)][number * width];
}

}  // namespace stroma
