// SPDX-License-Identifier: LGPL-2.1-or-later
// The layouts follow the chapter "File formats" of the Gmsh reference manual. Format 1 has neither header nor binary
// form; format 2 lists elements one by one with their tags; format 4 groups nodes and elements by geometrical entity,
// and an element's physical group is its entity's.
#include "components/topology/gmsh_reader.h"

#include <fstream>
#include <sstream>

#include "components/topology/gmsh_elements.h"
#include "components/topology/gmsh_views.h"

namespace stroma {

namespace {

class GmshParser {
 public:
  GmshParser(std::string_view bytes, const std::string& name) : bytes_(bytes), in_(bytes, name) {}

  GmshFile parse() {
    out_.version = 1;
    if (bytes_.starts_with("# vtk") || bytes_.substr(0, 1024).find("<VTKFile") != bytes_.npos)
      in_.fail("this is a file of VTK", "MeshVTKLoader for it");
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
      tags_.index(in_);
    } else if (section == "$ELM" || section == "$Elements") {
      if (!seen_nodes_) in_.fail("elements come before the nodes they use", "a section $Nodes first");
      if (seen_elements_) in_.fail("a second list of elements");
      seen_elements_ = true;
      inSection(section == "$ELM" ? "$ENDELM" : "$EndElements", [this] { readElementSection(); });
    } else if (seen_elements_ && (section == "$NodeData" || section == "$ElementData")) {
      const bool of_nodes = section == "$NodeData";
      if (!views_.read(of_nodes, out_.binary, in_, tags_, out_.data)) skipSection(section);
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
    if (!v40) {
      in_.number<std::uint64_t>("the smallest node tag");
      in_.number<std::uint64_t>("the largest node tag");
    }
    reserveNodes(nodes);
    for (std::size_t b = 0; b < blocks; ++b) {
      const int first = in_.number<int>("a node block's entity"), second = in_.number<int>("a node block's entity");
      const int dimension = v40 ? second : first;
      const int parameters = in_.number<int>("a node block's parametric flag") ? dimension : 0;
      const std::size_t count = readCount("nodes of a block", v40 ? 8 : 7);
      if (!v40)
        for (std::size_t i = 0; i < count; ++i) tags_.add(in_.number<std::int64_t>("a node's tag"));
      for (std::size_t i = 0; i < count; ++i) {
        if (v40) tags_.add(in_.number<int>("a node's tag"));
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
    if (!v40) {
      in_.number<std::uint64_t>("the smallest tag");
      in_.number<std::uint64_t>("the largest tag");
    }
    std::size_t total = 0;
    for (std::size_t b = 0; b < blocks; ++b) {
      const int first = in_.number<int>("an element block's entity"),
                second = in_.number<int>("an element block's entity");
      const std::pair<int, int> entity = v40 ? std::pair(second, first) : std::pair(first, second);
      const GmshElement element = gmshElement(in_.number<int>("an element block's type"), in_);
      const std::size_t count = readCount("elements of a block", 2);
      const auto group = entity_group_.find(entity);
      for (std::size_t i = 0; i < count; ++i) {
        tag_ = v40 ? std::int64_t(in_.number<int>("an element's tag")) : in_.number<std::int64_t>("an element's tag");
        std::array<std::int64_t, most_cell_nodes> tags{};
        for (int k = 0; k < element.nodes; ++k)
          tags[k] = v40 ? in_.number<int>("an element's node") : in_.number<std::int64_t>("an element's node");
        addElement(element, tags, group == entity_group_.end() ? 0 : group->second);
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
      tags_.add(in_.number<int>("a node's number"));
      readPosition();
    }
  }

  /// Number and type of an element.
  std::pair<int, GmshElement> readElementHead() {
    tag_ = in_.number<int>("an element's number");
    const int code = in_.number<int>("an element's type");
    return {code, gmshElement(code, in_)};
  }

  void readElements1() {
    const std::size_t count = elementCount();
    for (std::size_t i = 0; i < count; ++i) {
      const auto [code, element] = readElementHead();
      const int group = in_.number<int>("an element's physical region");
      in_.number<int>("an element's elementary region");
      const int nodes = in_.number<int>("an element's number of nodes");
      if (nodes != element.nodes)
        in_.fail(fmt::format("an element of type {} with {} nodes", code, nodes),
                 fmt::format("{} nodes", element.nodes));
      readElementNodes(element, group);
    }
  }

  void readElements2() {
    const std::size_t count = elementCount();
    for (std::size_t i = 0; i < count; ++i) {
      const GmshElement element = readElementHead().second;
      const int group = readTags(in_.number<int>("an element's number of tags"));
      readElementNodes(element, group);
    }
  }

  void readElements2Binary() {
    const std::size_t count = elementCount();
    in_.line();
    for (std::size_t done = 0; done < count;) {
      const GmshElement element = gmshElement(in_.number<int>("an element block's type"), in_);
      const auto in_block = in_.checkCount(in_.number<int>("the size of a block"), 8, "elements of a block");
      const int tags = in_.number<int>("an element's number of tags");
      if (in_block == 0 || in_block > count - done)
        in_.fail(fmt::format("a block of {} elements where {} are left", in_block, count - done));
      for (std::size_t i = 0; i < in_block; ++i) {
        tag_ = in_.number<int>("an element's number");
        readElementNodes(element, readTags(tags));
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

  void readElementNodes(const GmshElement& element, int group) {
    std::array<std::int64_t, most_cell_nodes> tags{};
    for (int k = 0; k < element.nodes; ++k) tags[k] = in_.number<int>("an element's node");
    addElement(element, tags, group);
  }

  // ---- all formats ----

  void reserveNodes(std::size_t count) {
    tags_.reserve(count);
    out_.mesh.position.reserve(count);
  }

  void readPosition() {
    Vec3 p;
    for (int k = 0; k < 3; ++k) p[k] = in_.number<double>("a node's position");
    out_.mesh.position.push_back(p);
  }

  void addElement(const GmshElement& element, const std::array<std::int64_t, most_cell_nodes>& tags, int group) {
    bool listed = false;
    const auto add = [&](const CellKind& kind, auto& cells, std::vector<int>& groups) {
      if (&kind != element.kind) return;
      auto& cell = cells.emplace_back();
      for (std::size_t k = 0; k < cell.size(); ++k) cell[kind.gmsh.order[k]] = tags_.nodeOf(tags[k], in_, "an element");
      groups.push_back(group);
      if (kind.dimension == 3) views_.addCell(kind.type, tag_);
      listed = true;
    };
    forEachCellList(add, out_.mesh, out_.groups);
    if (!listed) ++out_.skipped[std::string(element.name)];
  }

  std::string_view bytes_;
  GmshCursor in_;
  GmshFile out_;
  GmshTags tags_;
  GmshViews views_;
  bool seen_nodes_ = false, seen_elements_ = false;
  std::int64_t tag_ = 0;                             ///< of the element that is read
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
