// SPDX-License-Identifier: LGPL-2.1-or-later
// Meshes in three simple text formats used by SOFA's scenes.
//
// MeshTrianLoader: the number of nodes, x y z of each, the number of triangles, and for each three nodes (from 0) and three neighbours
//   (-1: none). With trian2 the file starts with thirteen header lines, each count follows a word, and normals come in between.
// GIDMeshLoader: "MESH dimension 3 ElemType Tetrahedra Nnode 4", then nodes between "Coordinates" and "End Coordinates" as a
//   number and coordinates, and cells between "Elements" and "End Elements" as a number and nodes (from 1). Types: Linear,
//   Triangle, Quadrilateral, Tetrahedra, Hexahedra. Of cells of higher order only the corners are used.
// MeshXspLoader: springs and masses. Lines "mass NUMBER s|v x y z vx vy vz mass elasticity" are nodes, and lines "lspg NUMBER a b
//   stiffness damping length" (nodes from 1) are edges. Other lines, and the values of masses and springs, are ignored.
//
// Source: the formats, names and attributes are SOFA's.
//
// Example:
// <Node name="root">
//   <MeshTrianLoader name="sheet" filename="meshes/block.trian"/>
//   <GIDMeshLoader name="solid" filename="meshes/block.gid"/>
//   <MeshXspLoader name="net" filename="meshes/two.xs3"/>
//   <TriangleSetTopologyContainer name="skin" src="@sheet"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <sstream>

#include "framework/mesh/mesh_loader.h"
#include "framework/scene/factory.h"
#include "framework/scene/text.h"

namespace stroma {
namespace {

constexpr long most_items = 100'000'000;

std::ifstream opened(const std::string& file) {
  std::ifstream stream(file);
  if (!stream) throw ComponentError(fmt::format("the file {} cannot be opened", file));
  return stream;
}

[[noreturn]] void failShort(const std::string& file, const std::string& where) {
  throw ComponentError(fmt::format("{}: {} is missing or no number", file, where), "as many as the counts say");
}

class MeshTrianLoader final : public MeshLoader {
 public:
  void declare(DataTable& table) override {
    MeshLoader::declare(table);
    table.add("trian2", second_).help("the file has a head and normals");
    for (const char* name : {"neighborTable", "edgesOnBorder", "trianglesOnBorderList"}) table.addVisualOnly(name);
  }

 protected:
  void read(const std::string& file, Mesh& mesh) override {
    std::ifstream stream = opened(file);
    constexpr int head_lines = 13;
    std::string line;
    for (int i = 0; second_ && i < head_lines; ++i) std::getline(stream, line);
    for (long i = 0, count = readCount(stream, file); i < count; ++i) {
      Vec3 p;
      if (!(stream >> p[0] >> p[1] >> p[2])) failShort(file, fmt::format("node {}", i));
      mesh.position.push_back(p);
    }
    if (second_)
      for (long i = 0, count = readCount(stream, file); i < count; ++i)
        if (double x, y, z; !(stream >> x >> y >> z)) failShort(file, fmt::format("normal {}", i));
    for (long i = 0, count = readCount(stream, file); i < count; ++i) {
      Triangle t;
      long neighbours[3] = {-1, -1, -1};
      bool good = bool(stream >> t[0] >> t[1] >> t[2]);
      if (!second_) good = good && bool(stream >> neighbours[0] >> neighbours[1] >> neighbours[2]);
      if (!good) failShort(file, fmt::format("triangle {}", i));
      mesh.triangles.push_back(t);
    }
  }

 private:
  long readCount(std::istream& stream, const std::string& file) const {
    std::string word;
    long count = -1;
    if (second_) stream >> word;
    if (!(stream >> count) || count < 0 || count > most_items) failShort(file, "a count");
    return count;
  }
  bool second_ = false;
};

class GIDMeshLoader final : public MeshLoader {
 protected:
  void read(const std::string& file, Mesh& mesh) override {
    std::ifstream stream = opened(file);
    std::string line, word, type;
    int dimension = 3, nodes = 0;
    std::getline(stream, line);
    std::istringstream head(line);
    while (head >> word) {
      if (word == "dimension") head >> dimension;
      if (word == "ElemType") head >> type;
      if (word == "Nnode") head >> nodes;
    }
    if (dimension < 1 || dimension > 3 || type.empty() || nodes < 2)
      throw ComponentError(fmt::format("{} does not begin as a mesh of GID", file), "MESH dimension 3 ElemType Tetrahedra Nnode 4");
    find(stream, "coordinates", file);
    forLines(stream, "end coordinates", file, [&](std::istringstream& words) {
      Vec3 p = Vec3::Zero();
      for (int c = 0; c < dimension; ++c) words >> p[c];
      mesh.position.push_back(p);
    });
    find(stream, "elements", file);
    forLines(stream, "end elements", file, [&](std::istringstream& words) { add(type, words, file, mesh); });
  }

 private:
  static std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return std::string(trimmed(text));
  }
  static void find(std::istream& stream, const std::string& wanted, const std::string& file) {
    for (std::string line; std::getline(stream, line);)
      if (lower(line) == wanted) return;
    failShort(file, wanted);
  }
  template <class Take>
  static void forLines(std::istream& stream, const std::string& end, const std::string& file, Take&& take) {
    for (std::string line; std::getline(stream, line);) {
      if (lower(line) == end) return;
      if (trimmed(line).empty()) continue;
      std::istringstream words(line);
      long number = 0;
      words >> number;
      take(words);
      if (!words) failShort(file, inQuotes(line));
    }
    failShort(file, end);
  }
  template <class Cell>
  static void addTo(std::vector<Cell>& cells, std::istringstream& words) {
    Cell cell;
    for (Index& node : cell) words >> node, --node;
    cells.push_back(cell);
  }
  static void add(const std::string& type, std::istringstream& words, const std::string& file, Mesh& mesh) {
    if (type == "Linear") return addTo(mesh.edges, words);
    if (type == "Triangle") return addTo(mesh.triangles, words);
    if (type == "Quadrilateral") return addTo(mesh.quads, words);
    if (type == "Tetrahedra") return addTo(mesh.tetrahedra, words);
    if (type == "Hexahedra") return addTo(mesh.hexahedra, words);
    throw ComponentError(fmt::format("{}: cells of the type {} are not read", file, type),
                         "Linear, Triangle, Quadrilateral, Tetrahedra or Hexahedra");
  }
};

class MeshXspLoader final : public MeshLoader {
 protected:
  void read(const std::string& file, Mesh& mesh) override {
    std::ifstream stream = opened(file);
    int number = 0;
    bool begun = false;
    for (std::string line; std::getline(stream, line);) {
      ++number;
      std::istringstream words(line);
      std::string word, kind;
      words >> word;
      begun = begun || word == "Xsp";
      if (word == "mass") {
        Vec3 p;
        if (long index; !(words >> index >> kind >> p[0] >> p[1] >> p[2])) failShort(file, fmt::format("line {}", number));
        mesh.position.push_back(p);
      } else if (word == "lspg" || word == "vspg") {
        Edge edge;
        if (long index; !(words >> index >> edge[0] >> edge[1])) failShort(file, fmt::format("line {}", number));
        mesh.edges.push_back({edge[0] - 1, edge[1] - 1});
      }
    }
    if (!begun) throw ComponentError(fmt::format("{} has no line Xsp", file), "a file of masses and springs");
  }
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(mesh_text_loaders) {
  factory.add<stroma::MeshTrianLoader>("MeshTrianLoader", "reads the triangles of a .trian file");
  factory.add<stroma::GIDMeshLoader>("GIDMeshLoader", "reads a mesh of GID");
  factory.add<stroma::MeshXspLoader>("MeshXspLoader", "reads the nodes and springs of a .xs3 file");
}
