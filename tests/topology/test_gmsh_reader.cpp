// SPDX-License-Identifier: LGPL-2.1-or-later
// The reader of .msh files against Gmsh's own library, on real meshes, and on files that are wrong.
#include "components/topology/gmsh_reader.h"

#include <gmsh.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <set>
#include <sstream>

#include "framework/scene/diagnostics.h"

namespace stroma::test {
namespace {

std::string bytesOf(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

/// The message of the error, or empty.
std::string errorOf(const std::string& bytes) {
  try {
    parseGmsh(bytes, "file.msh");
  } catch (const ComponentError& error) {
    return error.what();
  }
  return {};
}

class Gmsh : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    gmsh::initialize();
    gmsh::option::setNumber("General.Terminal", 0);
  }
  static void TearDownTestSuite() { gmsh::finalize(); }
  void SetUp() override {
    gmsh::clear(), folder_ = std::filesystem::temp_directory_path() / ("gmsh" + std::to_string(::getpid())),
                   std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  /// A box of tetrahedra, with physical groups of volume, one face and one edge.
  static void makeTetrahedra() {
    const int p[8] = {point(0, 0, 0), point(1, 0, 0), point(1, 1, 0), point(0, 1, 0), point(0, 0, 0), 0, 0, 0};
    const int a = gmsh::model::geo::addLine(p[0], p[1]), b = gmsh::model::geo::addLine(p[1], p[2]),
              c = gmsh::model::geo::addLine(p[2], p[3]), d = gmsh::model::geo::addLine(p[3], p[0]);
    const int surface = gmsh::model::geo::addPlaneSurface({gmsh::model::geo::addCurveLoop({a, b, c, d})});
    gmsh::vectorpair out;
    gmsh::model::geo::extrude({{2, surface}}, 0, 0, 0.7, out);
    gmsh::model::geo::synchronize();
    gmsh::model::setPhysicalName(3, gmsh::model::addPhysicalGroup(3, {out[1].second}, 11), "body");
    gmsh::model::setPhysicalName(2, gmsh::model::addPhysicalGroup(2, {surface}, 22), "the floor");
    gmsh::model::setPhysicalName(1, gmsh::model::addPhysicalGroup(1, {a}, 33), "rim");
    gmsh::option::setNumber("Mesh.SaveAll", 1);
    gmsh::model::mesh::generate(3);
  }
  static int point(double x, double y, double z) { return gmsh::model::geo::addPoint(x, y, z, 0.35); }

  /// The same box in hexahedra and quads.
  static void makeHexahedra() {
    const int a = gmsh::model::geo::addLine(point(0, 0, 0), point(2, 0, 0));
    gmsh::vectorpair face, body;
    gmsh::model::geo::extrude({{1, a}}, 0, 1, 0, face, {3}, {}, true);
    gmsh::model::geo::extrude({face[1]}, 0, 0, 1, body, {2}, {}, true);
    gmsh::model::geo::synchronize();
    gmsh::option::setNumber("Mesh.SaveAll", 1);
    gmsh::model::mesh::generate(3);
  }

  /// Compares with what the library holds: each node's position, each element's nodes, in order of their tags.
  void compare(const GmshFile& file) const {
    std::vector<std::size_t> tags;
    std::vector<double> coordinates, parameters;
    gmsh::model::mesh::getNodes(tags, coordinates, parameters);
    ASSERT_EQ(file.mesh.position.size(), tags.size());
    std::multiset<std::array<double, 3>> expected_nodes, nodes;
    for (std::size_t n = 0; n < tags.size(); ++n) {
      expected_nodes.insert(rounded(&coordinates[3 * n]));
      nodes.insert(at(file.mesh, Index(n)));
    }
    EXPECT_EQ(nodes, expected_nodes);
    std::map<std::size_t, std::array<double, 3>> position;
    for (std::size_t n = 0; n < tags.size(); ++n) position[tags[n]] = rounded(&coordinates[3 * n]);
    compareCells(file.mesh, file.mesh.edges, 1, position);
    compareCells(file.mesh, file.mesh.triangles, 2, position);
    compareCells(file.mesh, file.mesh.quads, 3, position);
    compareCells(file.mesh, file.mesh.tetrahedra, 4, position);
    compareCells(file.mesh, file.mesh.hexahedra, 5, position);
    compareCells(file.mesh, file.mesh.quadratic_triangles, 9, position);
    compareCells(file.mesh, file.mesh.quadratic_tetrahedra, 11, position);
  }

  static std::array<double, 3> at(const Mesh& mesh, Index node) { return rounded(mesh.position[node].data()); }
  /// The library writes 16 digits in ASCII.
  static std::array<double, 3> rounded(const double* p) {
    const auto round = [](double x) { return std::round(x * 1e12) / 1e12 + 0.0; };
    return {round(p[0]), round(p[1]), round(p[2])};
  }

  template <class Cell>
  static void compareCells(const Mesh& mesh, const std::vector<Cell>& cells, int type,
                           const std::map<std::size_t, std::array<double, 3>>& position) {
    std::vector<std::size_t> element_tags, node_tags;
    gmsh::model::mesh::getElementsByType(type, element_tags, node_tags);
    std::multiset<std::vector<std::array<double, 3>>> expected, found;
    const std::size_t size = std::tuple_size_v<Cell>;
    for (std::size_t e = 0; e < element_tags.size(); ++e) {
      std::vector<std::array<double, 3>> corners;
      for (std::size_t k = 0; k < size; ++k) corners.push_back(position.at(node_tags[size * e + k]));
      expected.insert(corners);
    }
    for (const Cell& cell : cells) {
      std::vector<std::array<double, 3>> corners;
      for (std::size_t k = 0; k < size; ++k)
        corners.push_back(at(mesh, cell[std::size_t(kindByNumber(&CellKind::gmsh, type)->gmsh.order[k])]));
      found.insert(corners);
    }
    EXPECT_EQ(found, expected) << "elements of type " << type;
  }

  std::string write(double version, bool binary) const {
    gmsh::option::setNumber("Mesh.MshFileVersion", version);
    gmsh::option::setNumber("Mesh.Binary", binary);
    const std::string file = folder_ / "mesh.msh";
    gmsh::write(file);
    return file;
  }

  std::filesystem::path folder_;
};

TEST_F(Gmsh, EveryFormatReadsAsTheLibraryHasIt) {
  for (const bool hexahedra : {false, true}) {
    gmsh::clear();
    hexahedra ? makeHexahedra() : makeTetrahedra();
    for (const double version : {1.0, 2.2, 4.0, 4.1})
      for (const bool binary : {false, true}) {
        if (binary && (version == 1 || version == 4)) continue;
        SCOPED_TRACE(testing::Message() << "version " << version << (binary ? " binary" : " ASCII"));
        const GmshFile file = readGmsh(write(version, binary));
        EXPECT_EQ(file.version, version);
        EXPECT_EQ(file.binary, binary);
        compare(file);
        EXPECT_EQ(file.mesh.firstError(), "");
        EXPECT_GT(hexahedra ? file.mesh.hexahedra.size() : file.mesh.tetrahedra.size(), 5u);
        EXPECT_NEAR(file.mesh.report().volume, hexahedra ? 2 : 0.7, 1e-9);
      }
  }
}

TEST_F(Gmsh, QuadraticTetrahedraReadAsTheLibraryHasThem) {
  makeTetrahedra();
  gmsh::model::mesh::setOrder(2);
  for (const double version : {1.0, 2.2, 4.0, 4.1})
    for (const bool binary : {false, true}) {
      if (binary && (version == 1 || version == 4)) continue;
      SCOPED_TRACE(testing::Message() << "version " << version << (binary ? " binary" : " ASCII"));
      const GmshFile file = readGmsh(write(version, binary));
      compare(file);
      EXPECT_EQ(file.mesh.firstError(), "");
      EXPECT_GT(file.mesh.quadratic_tetrahedra.size(), 5u);
      EXPECT_GT(file.mesh.quadratic_triangles.size(), 5u);
      EXPECT_GT(file.skipped.at("quadratic edges"), 3);
      EXPECT_NEAR(file.mesh.report().volume, 0.7, 1e-9);
      EXPECT_TRUE(file.mesh.report().inverted.empty());
      for (const QuadraticTetrahedron& cell : file.mesh.quadratic_tetrahedra)  // each middle between its corners
        for (std::size_t e = 0; e < 6; ++e) {
          const auto [a, b] = cell_tables::tetrahedron_middles[e];
          const auto& p = file.mesh.position;
          EXPECT_LT((p[cell[4 + e]] - (p[cell[std::size_t(a)]] + p[cell[std::size_t(b)]]) / 2).norm(), 1e-12);
        }
    }
}

TEST_F(Gmsh, PhysicalGroups) {
  makeTetrahedra();
  gmsh::option::setNumber("Mesh.SaveAll", 0);  // only what is in a group
  for (const double version : {2.2, 4.0, 4.1})
    for (const bool binary : {false, true}) {
      if (binary && version == 4) continue;
      SCOPED_TRACE(testing::Message() << "version " << version << (binary ? " binary" : " ASCII"));
      const GmshFile file = readGmsh(write(version, binary));
      EXPECT_EQ(file.group_names.at({2, 22}), "the floor");
      EXPECT_EQ(file.group_names.at({3, 11}), "body");
      ASSERT_EQ(file.groups.triangles.size(), file.mesh.triangles.size());
      ASSERT_GT(file.mesh.triangles.size(), 3u);
      for (std::size_t t = 0; t < file.mesh.triangles.size(); ++t) {
        EXPECT_EQ(file.groups.triangles[t], 22);
        for (const Index node : file.mesh.triangles[t]) EXPECT_EQ(file.mesh.position[node].z(), 0);
      }
      ASSERT_FALSE(file.groups.edges.empty());
      for (const int group : file.groups.edges) EXPECT_EQ(group, 33);
      ASSERT_FALSE(file.groups.tetrahedra.empty());
      for (const int group : file.groups.tetrahedra) EXPECT_EQ(group, 11);
    }
}

/// Views that the library writes behind the mesh: of elements in any order and not of all, and of nodes.
TEST_F(Gmsh, ViewsOfElementsAndNodes) {
  for (const bool hexahedra : {false, true}) {
    gmsh::clear();
    hexahedra ? makeHexahedra() : makeTetrahedra();
    std::vector<std::size_t> cells, unused, nodes;
    std::vector<double> position, parameters;
    gmsh::model::mesh::getElementsByType(hexahedra ? 5 : 4, cells, unused);
    gmsh::model::mesh::getNodes(nodes, position, parameters);
    std::string model;
    gmsh::model::getCurrent(model);
    const std::set<std::size_t> with_data(cells.begin() + 1, cells.end());
    std::vector<std::size_t> reversed(with_data.rbegin(), with_data.rend());
    std::vector<std::vector<double>> fibres, frames;
    for (const std::size_t tag : reversed) fibres.push_back({double(tag), 0.5, -double(tag)});
    for (const std::size_t tag : nodes) frames.push_back({1, 0, 0, 0, double(tag), 0, 0, 0, 3});
    for (const double version : {2.2, 4.1})
      for (const bool binary : {false, true}) {
        SCOPED_TRACE(testing::Message() << "version " << version << (binary ? " binary" : " ASCII"));
        const std::string file = write(version, binary);
        const auto add = [&](const std::string& name, const std::string& kind, const auto& tags, const auto& values) {
          const int view = gmsh::view::add(name);
          gmsh::view::addModelData(view, 0, model, kind, tags, values);
          gmsh::option::setNumber("PostProcessing.SaveMesh", 0);
          gmsh::view::write(view, file, true);
        };
        add("fibres", "ElementData", reversed, fibres);
        add("frames", "NodeData", nodes, frames);
        const GmshFile content = readGmsh(file);
        ASSERT_EQ(content.data.count("fibres"), 1u);
        const GmshData &of_cells = content.data.at("fibres"), &of_nodes = content.data.at("frames");
        EXPECT_EQ(of_cells.width, 3);
        EXPECT_EQ(of_nodes.width, 9);
        EXPECT_FALSE(of_cells.repeated);
        const auto type = hexahedra ? CellType::hexahedron : CellType::tetrahedron;
        const std::vector<double>& values = of_cells.cells[std::size_t(type)];
        ASSERT_EQ(values.size(), 3 * cells.size());
        for (std::size_t c = 0; c < cells.size(); ++c) {  // the library writes elements in the order it lists them
          const double tag = with_data.count(cells[c]) ? double(cells[c]) : 0;
          EXPECT_EQ(values[3 * c], tag);
          EXPECT_EQ(values[3 * c + 1], tag == 0 ? 0 : 0.5);
          EXPECT_EQ(values[3 * c + 2], -tag);
        }
        ASSERT_EQ(of_nodes.nodes.size(), 9 * std::size_t(content.mesh.nodes()));
        std::multiset<double> expected(nodes.begin(), nodes.end()), found;
        for (std::size_t n = 0; n < of_nodes.nodes.size(); n += 9) found.insert(of_nodes.nodes[n + 4]);
        EXPECT_EQ(found, expected);
        add("fibres", "ElementData", reversed, fibres);
        EXPECT_TRUE(readGmsh(file).data.at("fibres").repeated);
        if (binary) continue;
        const std::string bytes = bytesOf(file);
        for (std::size_t size = bytes.find("$ElementData") + 14; size + 40 < bytes.size(); size += 7) {
          try {
            parseGmsh(std::string_view(bytes).substr(0, size), "cut.msh");
            const std::string_view last = std::string_view(bytes).substr(0, size);
            const std::size_t begun = last.rfind('$');
            EXPECT_EQ(last.substr(begun, 4), "$End") << "cut at " << size;
          } catch (const ComponentError& error) {
            EXPECT_GT(std::string(error.what()).size(), 20u);
          }
        }
      }
  }
}

TEST_F(Gmsh, SparseNodeNumbers) {
  makeTetrahedra();
  const GmshFile dense = readGmsh(write(2.2, false));
  std::vector<std::size_t> tags;
  std::vector<double> coordinates, parameters;
  gmsh::model::mesh::getNodes(tags, coordinates, parameters);
  // Numbers with gaps of a thousand and beyond what a table by number could hold.
  std::istringstream in(bytesOf(write(2.2, false)));
  std::ostringstream out;
  std::string line;
  bool nodes = false, elements = false;
  while (std::getline(in, line)) {
    if (line[0] == '$') nodes = line == "$Nodes", elements = line == "$Elements";
    std::istringstream words(line);
    std::vector<std::string> word;
    for (std::string w; words >> w;) word.push_back(w);
    const auto spread = [](std::string& w) { w = std::to_string(7 + 1000l * std::stol(w)); };
    if (nodes && word.size() == 4) spread(word[0]);
    if (elements && word.size() > 4)
      for (std::size_t k = 3 + std::stoul(word[2]); k < word.size(); ++k) spread(word[k]);
    for (const auto& w : word) out << w << ' ';
    out << '\n';
  }
  const GmshFile sparse = parseGmsh(out.str(), "sparse.msh");
  EXPECT_EQ(sparse.mesh.tetrahedra, dense.mesh.tetrahedra);
  EXPECT_EQ(sparse.mesh.position, dense.mesh.position);
}

TEST_F(Gmsh, QuadraticHexahedraAreNamed) {
  makeHexahedra();
  gmsh::model::mesh::setOrder(2);
  for (const double version : {2.2, 4.1})
    for (const bool binary : {false, true})
      EXPECT_NE(errorOf(bytesOf(write(version, binary))).find("quadratic"), std::string::npos);
}

/// A file cut anywhere is an error with a sentence, or (cut after all that matters) a whole mesh: never a crash.
void cutEverywhere(const std::string& bytes, std::size_t step) {
  const Mesh whole = parseGmsh(bytes, "whole.msh").mesh;
  std::size_t errors = 0;
  for (std::size_t size = 0; size < bytes.size(); size += step) {
    try {
      const Mesh mesh = parseGmsh(std::string_view(bytes).substr(0, size), "cut.msh").mesh;
      ASSERT_EQ(mesh.tetrahedra, whole.tetrahedra) << "cut at " << size;
      ASSERT_GT(size + 20, bytes.size()) << "cut at " << size;
    } catch (const ComponentError& error) {
      ASSERT_GT(std::string(error.what()).size(), 20u);
      ++errors;
    }
  }
  EXPECT_GT(errors * step + 40, bytes.size());
}

TEST_F(Gmsh, CutAtEveryByte) {
  const int a = point(0, 0, 0);
  const int line = gmsh::model::geo::addLine(a, point(1, 0, 0));
  gmsh::vectorpair face, body;
  gmsh::model::geo::extrude({{1, line}}, 0, 1, 0, face, {1});
  gmsh::model::geo::extrude({face[1]}, 0, 0, 1, body, {1});
  gmsh::model::geo::synchronize();
  gmsh::option::setNumber("Mesh.MeshSizeFactor", 5);
  gmsh::option::setNumber("Mesh.SaveAll", 1);
  gmsh::model::mesh::generate(3);
  gmsh::option::setNumber("Mesh.MeshSizeFactor", 1);
  for (const double version : {1.0, 2.2, 4.0, 4.1})
    for (const bool binary : {false, true}) {
      if (binary && (version == 1 || version == 4)) continue;
      SCOPED_TRACE(testing::Message() << "version " << version << (binary ? " binary" : " ASCII"));
      cutEverywhere(bytesOf(write(version, binary)), 1);
    }
}

TEST_F(Gmsh, RandomBytesNeverCrash) {
  makeTetrahedra();
  std::mt19937 random(3);
  for (const double version : {1.0, 2.2, 4.1})
    for (const bool binary : {false, true}) {
      if (binary && (version == 1 || version == 4)) continue;
      const std::string bytes = bytesOf(write(version, binary));
      long refused = 0;
      for (int trial = 0; trial < 400; ++trial) {
        std::string damaged = bytes;
        for (int k = 0; k < 4; ++k) damaged[random() % damaged.size()] = char(random());
        try {
          const GmshFile file = parseGmsh(damaged, "damaged.msh");
          file.mesh.firstError();
        } catch (const ComponentError&) {
          ++refused;
        }
      }
      EXPECT_GT(refused, 20);
    }
}

TEST_F(Gmsh, BigEndianFilesRead) {
  makeTetrahedra();
  const std::string bytes = bytesOf(write(2.2, true));
  const Mesh expected = parseGmsh(bytes, "little.msh").mesh;
  // Swap every binary value of the file: the mark, then per node an int and three doubles, then all ints.
  std::string big = bytes;
  const auto swap = [&big](std::size_t at, std::size_t size) {
    std::reverse(big.begin() + std::ptrdiff_t(at), big.begin() + std::ptrdiff_t(at + size));
  };
  swap(bytes.find("2.2 1 8\n") + 8, 4);
  const auto afterCount = [&bytes](const std::string& section, std::size_t* count) {
    const std::size_t at = bytes.find(section) + section.size();
    *count = std::stoul(bytes.substr(at));
    return bytes.find('\n', at) + 1;
  };
  std::size_t nodes = 0, elements = 0;
  std::size_t at = afterCount("$Nodes\n", &nodes);
  for (std::size_t n = 0; n < nodes; ++n) {
    swap(at, 4), at += 4;
    for (int k = 0; k < 3; ++k) swap(at, 8), at += 8;
  }
  at = afterCount("$Elements\n", &elements);
  const std::size_t end = bytes.find("\n$EndElements", at);
  for (; at + 4 <= end; at += 4) swap(at, 4);
  const Mesh mesh = parseGmsh(big, "big.msh").mesh;
  EXPECT_EQ(mesh.position, expected.position);
  EXPECT_EQ(mesh.tetrahedra, expected.tetrahedra);
}

const char* const small_file =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n"
    "$Elements\n1\n1 4 2 0 1 1 2 3 4\n$EndElements\n";

std::string with(const std::string& from, const std::string& to) {
  std::string text = small_file;
  return text.replace(text.find(from), from.size(), to);
}

TEST(GmshErrors, SayLineAndCause) {
  EXPECT_EQ(errorOf(small_file), "");
  EXPECT_EQ(errorOf(with("2 1 0 0", "2 1 x 0")), "file.msh:7: 'x' is not a number");
  EXPECT_NE(errorOf(with("1 2 3 4\n", "1 2 3 9\n")).find("file.msh:13: an element names node 9"), std::string::npos);
  EXPECT_NE(errorOf(with("2 1 0 0", "1 1 0 0")).find("node number 1 appears twice"), std::string::npos);
  EXPECT_NE(errorOf(with("2.2 0 8", "3.1 0 8")).find("format 3.1 is not known"), std::string::npos);
  EXPECT_NE(errorOf(with("1 4 2 0 1", "1 77 2 0 1")).find("elements of type 77 are not known"), std::string::npos);
  EXPECT_NE(errorOf(with("1 4 2 0 1", "1 12 2 0 1")).find("quadratic hexahedra (27 nodes)"), std::string::npos);
  EXPECT_NE(errorOf(with("$EndNodes", "5 1 1 1\n$EndNodes")).find("'5' where the section should end"),
            std::string::npos);
  EXPECT_NE(errorOf("").find("has no nodes"), std::string::npos);
  EXPECT_NE(errorOf("solid ascii").find("a section must begin here"), std::string::npos);
}

TEST(GmshErrors, ViewsThatAreWrong) {
  const auto view = [](const std::string& counts, const std::string& entries) {
    return with("", "") + "\n$NodeData\n1\n\"v\"\n1\n0\n3\n" + counts + "\n" + entries + "\n$EndNodeData\n";
  };
  EXPECT_EQ(errorOf(view("0 3 1", "1 1 2 3")), "");
  EXPECT_EQ(errorOf(view("0 5 1", "whatever")), "") << "widths that Gmsh does not have are passed over";
  EXPECT_NE(errorOf(view("0 3 999999999", "1 1 2 3")).find("999999999 entries of a view are declared"),
            std::string::npos);
  EXPECT_NE(errorOf(view("0 3 1", "77 1 2 3")).find("a view names node 77"), std::string::npos);
  EXPECT_NE(errorOf(view("0 3 2", "1 1 2 3  2 1 2")).find("'$EndNodeData' is not a number"), std::string::npos);
  EXPECT_NE(errorOf(view("0 3 1", "1 1 2 3 4")).find("where the view should end"), std::string::npos);
}

TEST(GmshErrors, HugeCountsAllocateNothing) {
  EXPECT_NE(errorOf(with("$Nodes\n4\n", "$Nodes\n999999999999\n")).find("999999999999 nodes are declared, but only"),
            std::string::npos);
  EXPECT_NE(errorOf(with("$Nodes\n4\n", "$Nodes\n-3\n")).find("-3 nodes are declared"), std::string::npos);
  EXPECT_NE(errorOf(with("$Elements\n1\n", "$Elements\n88888888\n")).find("88888888 elements are declared"),
            std::string::npos);
}

TEST(GmshFiles, RealMeshes) {
  const std::string folder = STROMA_SHARED_DATA "/meshes/";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is absent";
  const struct {
    const char* file;
    Index nodes;
    std::size_t tetrahedra, triangles, hexahedra;
  } expected[] = {{"liver.msh", 181, 596, 0, 0},           {"liver2.msh", 507, 1493, 860, 0},
                  {"truthcylinder1.msh", 642, 2524, 0, 0}, {"cylinder.msh", 510, 2430, 0, 0},
                  {"torus2_low_res.msh", 264, 862, 0, 0},  {"nine_hexa.msh", 32, 0, 0, 9},
                  {"6_tetra_bad.msh", 17, 6, 0, 0}};
  for (const auto& e : expected) {
    SCOPED_TRACE(e.file);
    const GmshFile file = readGmsh(folder + e.file);
    EXPECT_EQ(file.mesh.nodes(), e.nodes);
    EXPECT_EQ(file.mesh.tetrahedra.size(), e.tetrahedra);
    EXPECT_EQ(file.mesh.hexahedra.size(), e.hexahedra);
    if (e.triangles) {
      EXPECT_EQ(file.mesh.triangles.size(), e.triangles);
    }
    EXPECT_EQ(file.mesh.firstError(), "");
  }
  const GmshFile cube = readGmsh(folder + "msh4_cube.msh");
  EXPECT_EQ(cube.version, 4.1);
  EXPECT_GT(cube.mesh.tetrahedra.size(), 0u);
  EXPECT_NEAR(cube.mesh.report().volume, 1, 1e-12);
}

}  // namespace
}  // namespace stroma::test
