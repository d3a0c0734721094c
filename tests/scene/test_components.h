// SPDX-License-Identifier: LGPL-2.1-or-later
// Small components with every kind of attribute, and scenes from text, for the tests of the scene layer.
#pragma once
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "framework/scene/load.h"

namespace stroma::testing {

class TestState : public Component {
 public:
  void declare(DataTable& table) override {
    table.add("position", position).alias("points").help("points").unit("m");
    table.add("velocity", velocity).help("velocities").unit("m/s");
    table.add("translation", translation).help("shift").unit("m");
  }
  void init() override {
    ++init_count;
    for (Vec3& point : position) point += translation;
  }
  std::string roleText() const override { return "mechanical state"; }
  std::vector<Vec3> position, velocity;
  Vec3 translation = Vec3::Zero();
  int init_count = 0;
};

/// Reads nothing: the file's size becomes the number of points.
class TestLoader : public Component {
 public:
  void declare(DataTable& table) override {
    table.add("filename", filename).help("mesh").required().input();
    table.add("translation", translation).help("shift").unit("m");
    table.add("position", position).help("points").unit("m").output();
    table.add("tetrahedra", tetrahedra).alias("tetras").help("cells").output();
  }
  void init() override {
    for (std::uintmax_t i = 0; i < std::filesystem::file_size(filename.found); ++i)
      position.push_back(Vec3(double(i), 0, 0) + translation);
    tetrahedra.push_back({0, 1, 2, 3});
  }
  std::string roleText() const override { return "mesh loader"; }
  FileName filename;
  Vec3 translation = Vec3::Zero();
  std::vector<Vec3> position;
  std::vector<Tetrahedron> tetrahedra;
};

class TestMesh : public Component {
 public:
  void declare(DataTable& table) override {
    table.add("position", position).help("points").unit("m");
    table.add("tetrahedra", tetrahedra).alias("tetras").help("cells");
  }
  std::string roleText() const override { return "mesh"; }
  std::vector<Vec3> position;
  std::vector<Tetrahedron> tetrahedra;
};

class TestRoi : public Component {
 public:
  void declare(DataTable& table) override {
    table.add("box", box).help("low and high corner").unit("m");
    table.add("position", position).help("points").unit("m");
    table.add("indices", indices).help("points inside").output();
  }
  void init() override {
    for (std::size_t i = 0; i < position.size(); ++i)
      if (box.size() == 6 && position[i][0] >= box[0] && position[i][0] <= box[3]) indices.push_back(int(i));
    if (indices.empty()) throw ComponentError("the box selects nothing", "a box that holds at least one point");
  }
  std::string roleText() const override { return "selection"; }
  std::vector<double> box;
  std::vector<Vec3> position;
  std::vector<int> indices;
};

class TestForce : public Component {
 public:
  enum class Method { small, large, polar };
  void declare(DataTable& table) override {
    table.add("youngModulus", young).help("stiffness").unit("Pa").physical().min(0, false);
    table.add("poissonRatio", poisson).help("transverse contraction").unit("-").min(0).max(0.5, false);
    table.addChoice("method", method, {"small", "large", "polar"}).help("rotation");
    table.add("indices", indices).help("nodes");
    table.add("scale", scale).help("factor").unit("-");
    table.addLink("mstate", mstate).help("state");
    table.addVisualOnly("glow");
  }
  void init() override {
    state = mstate.get();
    if (!state) state = find<TestState>();
    if (!state) throw ComponentError("there is no mechanical state in this node", "a TestState");
  }
  std::string roleText() const override { return "force field"; }
  std::vector<double> young{5000}, poisson{0.45};
  Method method = Method::large;
  std::vector<int> indices;
  double scale = 1;
  Link<TestState> mstate{"mechanical state"};
  TestState* state = nullptr;
};

inline void addTestComponents(Factory& factory) {
  factory.add<TestState>("TestState", "points");
  factory.add<TestLoader>("TestLoader", "points from a file");
  factory.add<TestMesh>("TestMesh", "points and cells");
  factory.add<TestRoi>("TestRoi", "points in a box");
  factory.add<TestForce>("TestForce", "a force");
}

/// A folder of its own for files of one test, removed with it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "stroma-XXXXXX").string();
    path_ = mkdtemp(pattern.data());
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  std::string path(const std::string& name = {}) const { return name.empty() ? path_ : path_ + "/" + name; }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(path(name), std::ios::binary) << text;
    return path(name);
  }

 private:
  std::string path_;
};

/// Loads scenes made of the components above.
class SceneTest : public ::testing::Test {
 protected:
  SceneTest() { addTestComponents(factory); }

  Scene load(const std::string& text, const std::vector<Override>& overrides = {}) {
    return loadScene(folder.write("scene.xml", text), overrides, factory, modules);
  }
  /// The problems of a scene that must not load.
  std::vector<Problem> problemsOf(const std::string& text, const std::vector<Override>& overrides = {}) {
    try {
      load(text, overrides);
    } catch (const SceneError& error) {
      std::vector<Problem> errors;
      for (const Problem& problem : error.diagnostics().problems())
        if (problem.severity == Severity::error) errors.push_back(problem);
      return errors;
    }
    ADD_FAILURE() << "the scene loads:\n" << text;
    return {};
  }
  /// The one problem of a scene.
  Problem problemOf(const std::string& text, const std::vector<Override>& overrides = {}) {
    std::vector<Problem> problems = problemsOf(text, overrides);
    for (const Problem& problem : problems)
      if (problems.size() != 1) ADD_FAILURE() << problem.text();
    return problems.empty() ? Problem{} : problems[0];
  }
  template <class T>
  T& get(const Scene& scene, const std::string& path) {
    auto* found = dynamic_cast<T*>(findComponent(*scene.root, path));
    if (!found) throw std::runtime_error("no " + path + " of that type");
    return *found;
  }

  TemporaryFolder folder;
  Factory factory;
  Modules modules{factory, std::vector<std::string>{}};
};

}  // namespace stroma::testing
