// SPDX-License-Identifier: LGPL-2.1-or-later
// Reads the geometry of a Wavefront .obj file: nodes (v), lines (l) and polygons (f).
//
// Nodes keep their number in the file (from 0), whatever the normals and texture coordinates of the corners, so that index lists made for
// the file stay valid. Triangles and quads are kept. A polygon with more corners is cut into triangles around its first corner. Materials,
// groups, normals and texture coordinates are ignored. VTK's reader is not used: it makes a node for each pair of position and normal,
// which changes the numbers, and takes 10 ms to open.
//
// Source: the format as published by Wavefront (Advanced Visualizer, appendix B1); the attributes are SOFA's.
//
// Example:
// <Node name="root">
//   <MeshOBJLoader name="loader" filename="meshes/block.obj"/>
//   <TriangleSetTopologyContainer name="skin" src="@loader"/>
// </Node>
#include <fmt/format.h>

#include <charconv>
#include <fstream>

#include "framework/mesh/mesh_loader.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// One line of the file, read word by word.
class Words {
 public:
  explicit Words(std::string_view line) : rest_(line) {}
  std::string_view next() {
    const std::size_t begin = std::min(rest_.find_first_not_of(" \t\r"), rest_.size());
    const std::size_t end = std::min(rest_.find_first_of(" \t\r", begin), rest_.size());
    const std::string_view word = rest_.substr(begin, end - begin);
    rest_.remove_prefix(end);
    return word;
  }

 private:
  std::string_view rest_;
};

class MeshOBJLoader : public MeshLoader {
 public:
  void declare(DataTable& table) override {
    MeshLoader::declare(table);
    for (const char* name :
         {"handleSeams", "loadMaterial", "defaultMaterial", "materials", "texcoords", "computeMaterialFaces"})
      table.addVisualOnly(name);
  }

 protected:
  void read(const std::string& file, Mesh& mesh) override {
    std::ifstream stream(file);
    if (!stream) throw ComponentError(fmt::format("the file {} cannot be opened", file));
    name_ = file.substr(file.rfind('/') + 1);
    std::string text;
    long polygons_cut = 0;
    for (line_ = 1; std::getline(stream, text); ++line_) {
      Words words(text);
      const std::string_view key = words.next();
      if (key == "v")
        mesh.position.push_back(readNode(words));
      else if (key == "l")
        readLine(words, mesh);
      else if (key == "f")
        polygons_cut += readPolygon(words, mesh);
    }
    if (polygons_cut > 0)
      inform(fmt::format("{} polygons of more than four corners were cut into triangles", polygons_cut));
  }

 private:
  [[noreturn]] void fail(const std::string& message, const std::string& expected = {}) const {
    throw ComponentError(fmt::format("{}:{}: {}", name_, line_, message), expected);
  }

  template <class T>
  T number(std::string_view word, const char* what) const {
    T value{};
    const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (word.empty() || error != std::errc() || stop != word.data() + word.size())
      fail(fmt::format("'{}' is not a number", word.substr(0, 40)), what);
    return value;
  }

  Vec3 readNode(Words& words) const {
    Vec3 p;
    for (Index k = 0; k < 3; ++k) p[k] = number<double>(words.next(), "three reals after v");
    return p;
  }

  /// "7", "7/1", "7//2" or "7/1/2": the node counts from 1, or from the end when negative.
  Index readCorner(std::string_view word, const Mesh& mesh) const {
    const long given = number<long>(word.substr(0, word.find('/')), "a node number");
    const long node = given < 0 ? mesh.nodes() + given : given - 1;
    if (given == 0 || node < 0 || node >= mesh.nodes())
      fail(fmt::format("node {} is not one of the {} nodes before this line", given, mesh.nodes()));
    return Index(node);
  }

  std::vector<Index> readCorners(Words& words, const Mesh& mesh) const {
    std::vector<Index> corners;
    for (auto word = words.next(); !word.empty(); word = words.next()) corners.push_back(readCorner(word, mesh));
    return corners;
  }

  void readLine(Words& words, Mesh& mesh) const {
    const auto corners = readCorners(words, mesh);
    if (corners.size() < 2) fail("a line needs two nodes");
    for (std::size_t i = 0; i + 1 < corners.size(); ++i) mesh.edges.push_back({corners[i], corners[i + 1]});
  }

  /// 1 when the polygon had to be cut.
  int readPolygon(Words& words, Mesh& mesh) const {
    const auto c = readCorners(words, mesh);
    if (c.size() < 3) fail("a polygon needs three nodes");
    if (c.size() == 4) {
      mesh.quads.push_back({c[0], c[1], c[2], c[3]});
      return 0;
    }
    for (std::size_t i = 1; i + 1 < c.size(); ++i) mesh.triangles.push_back({c[0], c[i], c[i + 1]});
    return c.size() > 4 ? 1 : 0;
  }

  std::string name_;
  long line_ = 0;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(mesh_obj_loader) {
  factory.add<stroma::MeshOBJLoader>("MeshOBJLoader", "reads the surface of a Wavefront .obj file");
}
