// SPDX-License-Identifier: LGPL-2.1-or-later
// The layouts follow the chapter "File formats" of the Gmsh reference manual. Format 1 has neither header nor binary
// form; format 2 lists elements one by one with their tags; format 4 groups nodes and elements by geometrical entity,
// and an element's physical group is its entity's.
#include "components/topology/gmsh_reader.h"

#include <fstream>
#include <sstream>
#include <unordered_map>

#include "components/topology/gmsh_cursor.h"

namespace stroma {

namespace {

struct ElementType {
  int nodes;
  int dimension;
  const char* name;  ///< null: unknown
  bool quadratic = false;
};

ElementType elementType(int code) {
  switch (code) {
    case 1:
      return {2, 1, "edges"};
    case 2:
      return {3, 2, "triangles"};
    case 3:
      return {4, 2, "quads"};
    case 4:
      return {4, 3, "tetrahedra"};
    case 5:
      return {8, 3, "hexahedra"};
    case 6:
      return {6, 3, "prisms"};
    case 7:
      return {5, 3, "pyramids"};
    case 15:
      return {1, 0, "points"};
    case 8:
      return {3, 1, "quadratic edges (3 nodes)", true};
    case 9:
      return {6, 2, "quadratic triangles (6 nodes)", true};
    case 10:
      return {9, 2, "quadratic quads (9 nodes)", true};
    case 11:
      return {10, 3, "quadratic tetrahedra (10 nodes)", true};
    case 12:
      return {27, 3, "quadratic hexahedra (27 nodes)", true};
    case 13:
      return {18, 3, "quadratic prisms (18 nodes)", true};
    case 14:
      return {14, 3, "quadratic pyramids (14 nodes)", true};
    case 16:
      return {8, 2, "quadratic quads (8 nodes)", true};
    case 17:
      return {20, 3, "quadratic hexahedra (20 nodes)", true};
    case 18:
      return {15, 3, "quadratic prisms (15 nodes)", true};
    case 19:
      return {13, 3, "quadratic pyramids (13 nodes)", true};
    default:
      return {0, 0, nullptr};
  }
}

class GmshParser {
 public:
  GmshParser(std::string_view bytes, const std::string& name) : in_(bytes, name) {}

  GmshFile parse() {
    out_.version = 1;
    while (true) {
      const std::string_view section = in_.word();
      if (section.empty()) break;
      if (section[0] != '$') in_.fail("a section must begin here", "a word like $Nodes");
      readSection(section);
    }
    if (!seen_nodes_) in_.fail("the file has no nodes", "a section $Nodes (or $NOD)");
    if (!seen_elements_) in_.fail("the file has no elements", "a section $Elements (or $ELM)");
    return std::move(out_);
  }

 private:
  void readSection(std::string_view section) {
    if (section == "$MeshFormat") {
      readFormat();
    } else if (section == "$PhysicalNames") {
      readNames();
    } else if (section == "$Entities" && out_.version >= 4) {
      inSection("$EndEntities", [this] { readEntities(); });
    } else if (section == "$NOD" || section == "$Nodes") {
      if (seen_nodes_) in_.fail("a second list of nodes");
      seen_nodes_ = true;
      inSection(section == "$NOD" ? "$ENDNOD" : "$EndNodes",
                [this] { out_.version >= 4 ? readNodeBlocks() : readNodes(); });
      indexTags();
    } else if (section == "$ELM" || section == "$Elements") {
      if (!seen_nodes_) in_.fail("elements come before the nodes they use", "a section $Nodes first");
      if (seen_elements_) in_.fail("a second list of elements");
      seen_elements_ = true;
      inSection(section == "$ELM" ? "$ENDELM" : "$EndElements", [this] { readElementSection(); });
    } else if (seen_elements_ && (section == "$NodeData" || section == "$ElementData")) {
      readData(section == "$NodeData");
    } else {
      skipSection(section);
    }
  }

  void readElementSection() {
    if (out_.version >= 4) return readElementBlocks();
    if (out_.version < 2) return readElements1();
    out_.binary ? readElements2Binary() : readElements2();
  }

  template <class Body>
  void inSection(std::string_view end, Body&& body) {
    // The counts of a format-2 file stay text in its binary form; those of format 4 do not.
    if (out_.binary) in_.line();
    in_.binary = out_.binary;
    body();
    in_.binary = false;
    if (const std::string_view found = in_.word(); found != end)
      in_.fail(fmt::format("'{}' where the section should end", found.substr(0, 40)), std::string(end));
  }

  void skipSection(std::string_view section) {
    const std::string end = "$End" + std::string(section.substr(1));
    const std::size_t found = in_.rest().find(end);
    if (found == std::string_view::npos) in_.fail(fmt::format("section {} does not end", section), end);
    in_.skip(found + end.size());
  }

  void readFormat() {
    out_.version = in_.textNumber<double>("the format's version");
    const int binary = in_.textNumber<int>("the format's kind");
    const int size = in_.textNumber<int>("the format's size of a real");
    const bool known = (out_.version >= 2 && out_.version < 3) || out_.version == 4 || out_.version == 4.1;
    if (!known) in_.fail(fmt::format("format {} is not known", out_.version), "format 1, 2.2, 4.0 or 4.1");
    if (size != 8) in_.fail(fmt::format("reals and counts of {} bytes", size), "8 bytes");
    out_.binary = binary == 1;
    if (out_.binary && out_.version == 4) in_.fail("format 4.0 is read in ASCII only", "format 4.1 or 2.2");
    if (out_.binary) {
      in_.line();
      in_.binary = true;
      const int one = in_.number<int>("the byte-order mark");
      in_.swapped = one == 0x01000000;
      if (one != 1 && !in_.swapped) in_.fail("the byte-order mark is not 1 in either order");
      in_.binary = false;
    }
    if (in_.word() != "$EndMeshFormat") in_.fail("the section $MeshFormat does not end", "$EndMeshFormat");
  }

  void readNames() {
    const auto count = in_.checkCount(in_.textNumber<std::int64_t>("the number of names"), 5, "physical names");
    for (std::size_t i = 0; i < count; ++i) {
      const int dimension = in_.textNumber<int>("a physical name's dimension");
      const int tag = in_.textNumber<int>("a physical name's tag");
      const std::string_view text = in_.line();
      const std::size_t first = text.find('"'), last = text.rfind('"');
      if (first == std::string_view::npos || last == first) in_.fail("a physical name without quotes", "\"name\"");
      out_.group_names[{dimension, tag}] = std::string(text.substr(first + 1, last - first - 1));
    }
    if (in_.word() != "$EndPhysicalNames") in_.fail("the section $PhysicalNames does not end", "$EndPhysicalNames");
  }

  // ---- format 4 ----

  std::size_t readCount(const char* what, std::size_t least_bytes) {
    return in_.checkCount(std::int64_t(in_.number<std::uint64_t>(what)), least_bytes, what);
  }

  void readEntities() {
    std::array<std::size_t, 4> count;
    for (auto& n : count) n = readCount("geometrical entities", 2);
    for (int dimension = 0; dimension < 4; ++dimension)
      for (std::size_t i = 0; i < count[dimension]; ++i) {
        const int tag = in_.number<int>("an entity's tag");
        const int reals = dimension == 0 && out_.version > 4 ? 3 : 6;
        for (int k = 0; k < reals; ++k) in_.number<double>("an entity's box");
        const std::size_t groups = readCount("physical groups of an entity", 1);
        for (std::size_t k = 0; k < groups; ++k) {
          const int group = std::abs(in_.number<int>("an entity's physical group"));
          if (k == 0) entity_group_[{dimension, tag}] = group;
        }
        if (dimension == 0) continue;
        const std::size_t bounds = readCount("boundary entities of an entity", 1);
        for (std::size_t k = 0; k < bounds; ++k) in_.number<int>("an entity's boundary");
      }
  }

  void readNodeBlocks() {
    const bool v40 = out_.version == 4;
    const std::size_t blocks = readCount("node blocks", 4), nodes = readCount("nodes", v40 ? 8 : 7);
    if (!v40) in_.number<std::uint64_t>("the smallest node tag"), in_.number<std::uint64_t>("the largest node tag");
    reserveNodes(nodes);
    for (std::size_t b = 0; b < blocks; ++b) {
      const int first = in_.number<int>("a node block's entity"), second = in_.number<int>("a node block's entity");
      const int dimension = v40 ? second : first;
      const int parameters = in_.number<int>("a node block's parametric flag") ? dimension : 0;
      const std::size_t count = readCount("nodes of a block", v40 ? 8 : 7);
      if (!v40)
        for (std::size_t i = 0; i < count; ++i) tags_.push_back(in_.number<std::int64_t>("a node's tag"));
      for (std::size_t i = 0; i < count; ++i) {
        if (v40) tags_.push_back(in_.number<int>("a node's tag"));
        readPosition();
        for (int k = 0; k < parameters; ++k) in_.number<double>("a node's parameter");
      }
    }
    if (tags_.size() != nodes)
      in_.fail(fmt::format("{} nodes are declared, but the blocks hold {}", nodes, tags_.size()));
  }

  void readElementBlocks() {
    const bool v40 = out_.version == 4;
    const std::size_t blocks = readCount("element blocks", 4), elements = readCount("elements", 2);
    if (!v40) in_.number<std::uint64_t>("the smallest tag"), in_.number<std::uint64_t>("the largest tag");
    std::size_t total = 0;
    for (std::size_t b = 0; b < blocks; ++b) {
      const int first = in_.number<int>("an element block's entity"),
                second = in_.number<int>("an element block's entity");
      const std::pair<int, int> entity = v40 ? std::pair(second, first) : std::pair(first, second);
      const int code = in_.number<int>("an element block's type");
      const ElementType type = checkedType(code);
      const std::size_t count = readCount("elements of a block", 2);
      const auto group = entity_group_.find(entity);
      for (std::size_t i = 0; i < count; ++i) {
        tag_ = v40 ? std::int64_t(in_.number<int>("an element's tag")) : in_.number<std::int64_t>("an element's tag");
        std::array<std::int64_t, 8> tags{};
        for (int k = 0; k < type.nodes; ++k)
          tags[k] = v40 ? in_.number<int>("an element's node") : in_.number<std::int64_t>("an element's node");
        addElement(code, type, tags, group == entity_group_.end() ? 0 : group->second);
      }
      total += count;
    }
    if (total != elements) in_.fail(fmt::format("{} elements are declared, but the blocks hold {}", elements, total));
  }

  // ---- formats 1 and 2 ----

  void readNodes() {
    const auto declared = in_.textNumber<std::int64_t>("the number of nodes");
    const std::size_t nodes = in_.checkCount(declared, 8, "nodes");
    if (in_.binary) in_.line();
    reserveNodes(nodes);
    for (std::size_t i = 0; i < nodes; ++i) {
      tags_.push_back(in_.number<int>("a node's number"));
      readPosition();
    }
  }

  void readElements1() {
    const std::size_t count = elementCount();
    for (std::size_t i = 0; i < count; ++i) {
      tag_ = in_.number<int>("an element's number");
      const int code = in_.number<int>("an element's type");
      const ElementType type = checkedType(code);
      const int group = in_.number<int>("an element's physical region");
      in_.number<int>("an element's elementary region");
      const int nodes = in_.number<int>("an element's number of nodes");
      if (nodes != type.nodes)
        in_.fail(fmt::format("an element of type {} with {} nodes", code, nodes), fmt::format("{} nodes", type.nodes));
      readElementNodes(code, type, group);
    }
  }

  void readElements2() {
    const std::size_t count = elementCount();
    for (std::size_t i = 0; i < count; ++i) {
      tag_ = in_.number<int>("an element's number");
      const int code = in_.number<int>("an element's type");
      const ElementType type = checkedType(code);
      const int group = readTags(in_.number<int>("an element's number of tags"));
      readElementNodes(code, type, group);
    }
  }

  void readElements2Binary() {
    const std::size_t count = elementCount();
    in_.line();
    for (std::size_t done = 0; done < count;) {
      const int code = in_.number<int>("an element block's type");
      const ElementType type = checkedType(code);
      const auto in_block = in_.checkCount(in_.number<int>("the size of a block"), 8, "elements of a block");
      const int tags = in_.number<int>("an element's number of tags");
      if (in_block == 0 || in_block > count - done)
        in_.fail(fmt::format("a block of {} elements where {} are left", in_block, count - done));
      for (std::size_t i = 0; i < in_block; ++i) {
        tag_ = in_.number<int>("an element's number");
        readElementNodes(code, type, readTags(tags));
      }
      done += in_block;
    }
  }

  std::size_t elementCount() {
    return in_.checkCount(in_.textNumber<std::int64_t>("the number of elements"), 6, "elements");
  }

  /// The first tag is the physical group.
  int readTags(int count) {
    in_.checkCount(count, 1, "tags of an element");
    int group = 0;
    for (int k = 0; k < count; ++k) {
      const int tag = in_.number<int>("an element's tag");
      if (k == 0) group = std::abs(tag);
    }
    return group;
  }

  void readElementNodes(int code, const ElementType& type, int group) {
    std::array<std::int64_t, 8> tags{};
    for (int k = 0; k < type.nodes; ++k) tags[k] = in_.number<int>("an element's node");
    addElement(code, type, tags, group);
  }

  // ---- all formats ----

  /// A view: names, times and numbers as text, then a tag and its values for each node or element.
  void readData(bool of_nodes) {
    std::string name;
    const auto names =
        in_.checkCount(in_.textNumber<std::int64_t>("the number of a view's names"), 1, "names of a view");
    in_.line();
    for (std::size_t i = 0; i < names; ++i) {
      const std::string_view text = in_.line();
      const std::size_t first = text.find('"'), last = text.rfind('"');
      if (i == 0) name = first == last ? text : text.substr(first + 1, last - first - 1);
    }
    const auto reals =
        in_.checkCount(in_.textNumber<std::int64_t>("the number of a view's times"), 2, "times of a view");
    for (std::size_t i = 0; i < reals; ++i) in_.textNumber<double>("a view's time");
    const auto whole =
        in_.checkCount(in_.textNumber<std::int64_t>("the number of a view's counts"), 2, "counts of a view");
    std::int64_t count[3] = {0, 0, 0};  // time step, width, entries
    for (std::size_t i = 0; i < whole; ++i) {
      const auto value = in_.textNumber<std::int64_t>("a view's count");
      if (i < 3) count[i] = value;
    }
    if (count[1] != 1 && count[1] != 3 && count[1] != 9) return skipSection(of_nodes ? "$NodeData" : "$ElementData");
    const std::size_t width = std::size_t(count[1]);
    const auto entries = in_.checkCount(count[2], 2 * (width + 1), "entries of a view");
    if (out_.binary) in_.line();
    in_.binary = out_.binary;
    readEntries(of_nodes, out_.data[name], width, entries);
    in_.binary = false;
    const std::string_view end = of_nodes ? "$EndNodeData" : "$EndElementData";
    if (const std::string_view found = in_.word(); found != end)
      in_.fail(fmt::format("'{}' where the view should end", found.substr(0, 40)), std::string(end));
  }

  void readEntries(bool of_nodes, GmshData& data, std::size_t width, std::size_t entries) {
    const auto prepare = [&](std::vector<double>& values, std::size_t size) { values.assign(size * width, 0.); };
    const bool seen = of_nodes ? !data.nodes.empty() : !data.tetrahedra.empty() || !data.hexahedra.empty();
    data.repeated = data.repeated || seen || (data.width != 0 && data.width != int(width));
    if (!data.repeated) {
      data.width = int(width);
      if (of_nodes) prepare(data.nodes, tags_.size());
      if (!of_nodes) {
        prepare(data.tetrahedra, cell_tags_[0].size()), prepare(data.hexahedra, cell_tags_[1].size());
        indexCells();
      }
    }
    for (std::size_t i = 0; i < entries; ++i) {
      const std::int64_t tag = in_.number<int>("a view's entry");
      double* place = data.repeated ? nullptr
                      : of_nodes    ? &data.nodes[std::size_t(nodeOf(tag, "a view")) * width]
                                    : nullptr;
      if (!data.repeated && !of_nodes)
        if (const auto cell = cell_of_tag_.find(tag); cell != cell_of_tag_.end())
          place = &(cell->second.first == 0 ? data.tetrahedra : data.hexahedra)[cell->second.second * width];
      for (std::size_t k = 0; k < width; ++k) {
        const double value = in_.number<double>("a view's value");
        if (place) place[k] = value;
      }
    }
  }
  void indexCells() {
    for (std::size_t kind = 0; kind < 2 && cell_of_tag_.empty(); ++kind)
      for (std::size_t c = 0; c < cell_tags_[kind].size(); ++c) cell_of_tag_[cell_tags_[kind][c]] = {kind, c};
  }

  void reserveNodes(std::size_t count) {
    tags_.reserve(count);
    out_.mesh.position.reserve(count);
  }

  void readPosition() {
    Vec3 p;
    for (int k = 0; k < 3; ++k) p[k] = in_.number<double>("a node's position");
    out_.mesh.position.push_back(p);
  }

  ElementType checkedType(int code) {
    const ElementType type = elementType(code);
    if (!type.name) in_.fail(fmt::format("elements of type {} are not known", code), "Gmsh's linear elements");
    if (type.quadratic)
      in_.fail(fmt::format("{} are not supported", type.name), "linear elements (Mesh.ElementOrder = 1 in Gmsh)");
    return type;
  }

  /// Tags may have gaps and any order: dense ones get a table, sparse ones a sorted list.
  void indexTags() {
    std::int64_t largest = 0;
    for (const std::int64_t tag : tags_) {
      if (tag < 1) in_.fail(fmt::format("node number {} is not positive", tag));
      largest = std::max(largest, tag);
    }
    dense_ = std::uint64_t(largest) <= 8 * std::uint64_t(tags_.size()) + 1024;
    if (dense_) node_of_tag_.assign(std::size_t(largest) + 1, -1);
    for (std::size_t n = 0; n < tags_.size(); ++n) {
      if (!dense_) {
        sparse_.push_back({tags_[n], Index(n)});
      } else {
        if (node_of_tag_[tags_[n]] >= 0) in_.fail(fmt::format("node number {} appears twice", tags_[n]));
        node_of_tag_[tags_[n]] = Index(n);
      }
    }
    std::sort(sparse_.begin(), sparse_.end());
    for (std::size_t i = 0; i + 1 < sparse_.size(); ++i)
      if (sparse_[i].first == sparse_[i + 1].first)
        in_.fail(fmt::format("node number {} appears twice", sparse_[i].first));
  }

  Index nodeOf(std::int64_t tag, const char* who = "an element") {
    if (dense_) {
      if (tag > 0 && std::uint64_t(tag) < node_of_tag_.size() && node_of_tag_[tag] >= 0) return node_of_tag_[tag];
    } else {
      const auto it = std::lower_bound(sparse_.begin(), sparse_.end(), std::pair(tag, Index(0)));
      if (it != sparse_.end() && it->first == tag) return it->second;
    }
    in_.fail(fmt::format("{} names node {}, which the file does not have", who, tag));
  }

  template <std::size_t N>
  std::array<Index, N> nodesOf(const std::array<std::int64_t, 8>& tags) {
    std::array<Index, N> nodes;
    for (std::size_t k = 0; k < N; ++k) nodes[k] = nodeOf(tags[k]);
    return nodes;
  }

  void addElement(int code, const ElementType& type, const std::array<std::int64_t, 8>& tags, int group) {
    const auto add = [&]<std::size_t N>(std::vector<std::array<Index, N>>& cells, std::vector<int>& groups) {
      cells.push_back(nodesOf<N>(tags));
      groups.push_back(group);
    };
    switch (code) {
      case 1:
        return add(out_.mesh.edges, out_.edge_groups);
      case 2:
        return add(out_.mesh.triangles, out_.triangle_groups);
      case 3:
        return add(out_.mesh.quads, out_.quad_groups);
      case 4:
        cell_tags_[0].push_back(tag_);
        return add(out_.mesh.tetrahedra, out_.tetrahedron_groups);
      case 5:
        cell_tags_[1].push_back(tag_);
        return add(out_.mesh.hexahedra, out_.hexahedron_groups);
      default:
        ++out_.skipped[type.name];
    }
  }

  GmshCursor in_;
  GmshFile out_;
  bool seen_nodes_ = false, seen_elements_ = false, dense_ = true;
  std::vector<std::int64_t> tags_;
  std::int64_t tag_ = 0;                    ///< of the element that is read
  std::vector<std::int64_t> cell_tags_[2];  ///< of tetrahedra and hexahedra, in the order of the mesh
  std::unordered_map<std::int64_t, std::pair<std::size_t, std::size_t>> cell_of_tag_;  ///< kind and number in its list
  std::vector<Index> node_of_tag_;
  std::vector<std::pair<std::int64_t, Index>> sparse_;
  std::map<std::pair<int, int>, int> entity_group_;  ///< (dimension, entity) to physical group
};

}  // namespace

GmshFile parseGmsh(std::string_view bytes, const std::string& name) { return GmshParser(bytes, name).parse(); }

GmshFile readGmsh(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw ComponentError(fmt::format("the file {} cannot be opened", file));
  std::ostringstream text;
  text << stream.rdbuf();
  const std::string bytes = std::move(text).str();
  return parseGmsh(bytes, file.substr(file.rfind('/') + 1));
}

}  // namespace stroma
