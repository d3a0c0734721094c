// SPDX-License-Identifier: LGPL-2.1-or-later
// Files of masses and springs that components of SOFA read themselves: what they hold becomes attributes.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "framework/scene/dialect.h"
#include "framework/scene/files.h"
#include "framework/scene/names.h"
#include "framework/scene/text.h"
#include "tools/sofa/rewriting.h"

namespace stroma {

/// SOFA finds files in `share` and `examples` of its tree: those of the tree that the scene lies in. The scene's own folder comes last,
/// for files that an included file names.
std::vector<std::string> foreignDataPaths(const std::string& file) {
  namespace fs = std::filesystem;
  std::error_code none;
  std::vector<std::string> folders;
  const fs::path own = fs::absolute(file, none).lexically_normal().parent_path();
  for (fs::path at = own; at.has_relative_path(); at = at.parent_path()) {
    if (!fs::is_directory(at / "examples", none)) continue;
    const bool has_share = fs::is_directory(at / "share", none);  // a tree of sources; where it is installed, meshes lie beside
    if (!has_share && !fs::is_directory(at / "mesh", none)) continue;
    folders.push_back((has_share ? at / "share" : at).string());
    folders.push_back((at / "examples").string());
  }
  folders.push_back(own.string());
  return folders;
}

namespace sofa {

namespace {

/// Numbers of the lines that begin with a word, after those that are passed over; false: a line has too few.
bool numbersOfLines(std::ifstream& file, const char* first, int passed, int taken, std::vector<std::vector<double>>& lines) {
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string word;
    if (!(words >> word) || word != first) continue;
    for (int i = 0; i < passed; ++i) words >> word;
    std::vector<double> numbers(static_cast<std::size_t>(taken));
    for (double& number : numbers)
      if (!(words >> number)) return false;
    lines.push_back(std::move(numbers));
  }
  return true;
}

}  // namespace

/// Of scenes that were not read from a file too.
void Rewriting::addFoldersOfTree() {
  if (scene_.data_paths.empty()) scene_.data_paths = environmentDataPaths();
  for (const std::string& folder : foreignDataPaths(scene_.file))
    if (std::find(scene_.data_paths.begin(), scene_.data_paths.end(), folder) == scene_.data_paths.end())
      scene_.data_paths.push_back(folder);
}

/// Of a loader that nothing with an effect reads.
void Rewriting::tellMissingFile(const Element& loader) {
  const AttributeDescription* given = loader.find("filename");
  const std::string name(given ? trimmed(given->value) : "");
  if (name.empty() || name.front() == '@') return;
  if (findFileIn(name, loader.written->folder, scene_.data_paths, nullptr).empty())
    diagnostics_.warning(given->where, loader.path() + ".filename",
                         "the file " + inQuotes(name) + " is not found: nothing with an effect reads it");
}

/// What a component reads of a file: lines "mass NUMBER s|v x y z vx vy vz mass elasticity", where a mass below zero is that of a
/// node that is held, and "lspg NUMBER a b stiffness damping length", nodes from 1, of a .xs3; "sphe NUMBER x y z radius" of a .sph.
void Rewriting::readOwnFile(Element& element) {
  struct Reading {
    const char *type, *attribute, *other, *ending, *line;
    int passed, taken, kept;  ///< words after the first, numbers then, and how many of them are at the end
  };
  static const std::vector<Reading> readings = {{"SpringForceField", "filename", "fileSprings", ".xs3", "lspg", 1, 5, 5},
                                                {"DiagonalMass", "filename", "fileMass", ".xs3", "mass", 2, 7, 1},
                                                {"MechanicalObject", "filename", "filename", ".xs3", "mass", 2, 3, 3},
                                                {"RigidMapping", "filename", "fileRigidMapping", ".xs3", "mass", 2, 3, 3},
                                                {"RigidMapping", "filename", "fileRigidMapping", ".sph", "sphe", 1, 3, 3},
                                                {"SphereCollisionModel", "filename", "fileSphere", ".sph", "sphe", 1, 4, 1}};
  for (const Reading& reading : readings) {
    const AttributeDescription* given = element.find(reading.attribute);
    if (!given) given = element.find(reading.other);
    const std::string name(given ? trimmed(given->value) : "");
    if (!given || !element.is(reading.type) || !name.ends_with(reading.ending)) continue;
    const std::string attribute = given->name;
    const SourceLocation where = given->where;
    element.remove(attribute);
    std::vector<std::string> searched;
    const std::string path = findFileIn(name, element.written->folder, scene_.data_paths, &searched);
    std::ifstream file(path);
    std::vector<std::vector<double>> lines;
    if (path.empty() || !numbersOfLines(file, reading.line, reading.passed, reading.taken, lines))
      return diagnostics_.error(where, element.path() + "." + attribute,
                                path.empty() ? "the file " + inQuotes(name) + " is not found"
                                             : name + " has a line " + reading.line + " with too few numbers",
                                "", path.empty() ? searchedText(searched) : "");
    if (lines.empty() && !element.is("SpringForceField"))  // a field may have no springs
      return diagnostics_.error(where, element.path() + "." + attribute, name + " has no line " + reading.line);
    std::string text;
    for (const std::vector<double>& numbers : lines)
      for (std::size_t i = std::size_t(reading.taken - reading.kept); i < numbers.size(); ++i) {
        const double number = element.is("DiagonalMass") ? std::abs(numbers[i]) : numbers[i];
        text += (text.empty() ? "" : " ") + printReal(element.is("SpringForceField") && i < 2 ? number - 1 : number);
      }
    return takeOfFile(element, text);
  }
}

void Rewriting::replaceByFile(Element& element, const std::string& attribute, const std::string& numbers) {
  if (const AttributeDescription* written = element.find(attribute))
    warn(written->where, element, attribute, "is read of a file too: that counts, and what is written does not");
  element.set(attribute, numbers);
}

void Rewriting::takeOfFile(Element& element, const std::string& numbers) {
  if (element.is("DiagonalMass")) return replaceByFile(element, "vertexMass", numbers);
  if (element.is("MechanicalObject")) return replaceByFile(element, "position", numbers);
  if (element.is("SphereCollisionModel")) return replaceByFile(element, "listRadius", numbers);
  if (element.is("SpringForceField")) return element.set("spring", element.text("spring") + " " + numbers);
  Element* points = element.place->firstOf("mechanical state");  // places in the axes of the frame
  if (!points)
    return diagnostics_.error(element.written->where, element.path(), "there is no state for the points of the file",
                              "a MechanicalObject in the node");
  if (points->find("position") || element.find("initialPoints"))
    warn(element.written->where, element, "", "reads points of a file: they count, and those that are written do not");
  element.remove("initialPoints");
  points->set("position", numbers);
}

/// The surfaces of a grid of several, each from a file.
void Rewriting::readSurfaces(Element& grid) {
  const std::string written = grid.text("fileTopologies");
  Words files(written);
  int count = 0;
  for (std::string file(files.next()); !file.empty(); file = files.next()) {
    const std::string_view type = loaderOf(file);
    const SourceLocation& where = grid.find("fileTopologies")->where;
    const std::string name = grid.name + "_file" + std::to_string(++count);
    if (type.empty()) {
      diagnostics_.error(where, grid.path() + ".fileTopologies", "there is no loader for " + inQuotes(file), "a file of OBJ or .trian");
      continue;
    }
    grid.place->added_components.push_back(
        {std::string(type), {{"name", name, where}, {"filename", file, where}}, where, grid.written->folder});
    SceneTree::linkTo(grid);
    for (const char* list : {"position", "triangles", "quads"})
      grid.set(list + std::to_string(count), "@" + joinPath(grid.place->path(), name) + "." + list);
  }
  grid.remove("fileTopologies");
}

}  // namespace sofa
}  // namespace stroma
