// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/bench/body.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <stdexcept>

namespace stroma::bench {
namespace {

namespace fs = std::filesystem;

std::string& chosenFolder() {
  static std::string folder;
  return folder;
}

/// Components are code in modules: this outlives every simulation.
struct Library {
  Factory factory;
  Modules modules{factory};
};
Library& library() {
  static Library instance;
  return instance;
}

std::string replaced(const std::string& file, const std::vector<Replacement>& replacements) {
  std::ifstream stream(file);
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  for (const auto& [piece, other] : replacements) {
    const auto at = text.find(piece);
    if (at == std::string::npos) throw std::runtime_error(fmt::format("{}: it has no {}", file, piece));
    text.replace(at, piece.size(), other);
  }
  return text;
}

void deform(ConstRows rest, Shape shape, Rows out) {
  Vec3 low = rest[0], high = rest[0];
  for (Index i = 0; i < rest.count; ++i) low = low.cwiseMin(rest[i]), high = high.cwiseMax(rest[i]);
  const Vec3 centre = (low + high) / 2, extent = high - low;
  const double distance = std::cbrt(extent.prod() / rest.count);
  const double amplitude = (shape == Shape::crumpled ? 0.6 : 0.1) * distance;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> noise(-amplitude, amplitude);
  for (Index i = 0; i < rest.count; ++i) {
    const Eigen::AngleAxisd twist(2 * (rest[i].x() - low.x()) / extent.x(), Vec3::UnitX());
    out[i] = centre + twist * (rest[i] - centre) + Vec3(noise(random), noise(random), noise(random));
  }
}

}  // namespace

std::string programFolder() { return fs::read_symlink("/proc/self/exe").parent_path().string(); }

void setSceneFolder(const std::string& folder) { chosenFolder() = folder; }

std::string sceneFolder() {
  if (!chosenFolder().empty()) return chosenFolder();
  return (fs::path(programFolder()) / "../share/stroma/scenes")
      .lexically_normal()
      .string();  // a build folder has a link
}

std::unique_ptr<Simulation> loadSimulation(const std::string& scene, const std::vector<std::string>& overrides,
                                           const std::vector<Replacement>& replacements) {
  std::vector<Override> parsed;
  parsed.reserve(overrides.size());
  for (const std::string& text : overrides) parsed.push_back(Override::parse(text));
  const std::string file = sceneFolder() + "/" + scene;
  auto& [factory, modules] = library();
  auto simulation = std::make_unique<Simulation>(
      replacements.empty() ? loadScene(file, parsed, factory, modules)
                           : loadSceneText(replaced(file, replacements), file, parsed, factory, modules));
  simulation->dropObservers();
  return simulation;
}

Simulation& keptSimulation(const std::string& name, int first_steps, const std::string& scene, const std::vector<std::string>& overrides,
                           const std::vector<Replacement>& replacements) {
  library();  // made before what is kept, so destroyed after it
  static std::string kept_name;
  static std::unique_ptr<Simulation> kept;
  if (name == kept_name) return *kept;
  kept_name.clear();
  kept.reset();
  kept = loadSimulation(scene, overrides, replacements);
  kept->computeOnDemand(true);
  for (int i = 0; i < first_steps; ++i) kept->step();
  kept_name = name;
  return *kept;
}

Work factorWork(const Simulation& simulation) {
  std::vector<LinearSolver*> solvers;
  simulation.root().collect(solvers);
  Work work;
  for (const LinearSolver* solver : solvers) {
    const Data *flops = solver->data().find("factorFlops"), *entries = solver->data().find("factorEntries");
    if (!flops || !entries) continue;
    const double numbers = *std::get<double*>(entries->pointer());
    work = work + Work{3 * 8 * numbers, *std::get<double*>(flops->pointer()) + 4 * numbers};
  }
  return work;
}

Body::Body(const std::string& scene, const std::vector<std::string>& overrides, Shape shape)
    : simulation(loadSimulation(scene, overrides)) {
  system = simulation->systems().at(0).get();
  field = system->forceFields().at(0);
  for (Vector* vector : {&x, &v, &dx, &f, &df}) vector->resize(system->allRows());
  deform(system->x.rows(), shape, x);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> direction(-1e-3, 1e-3);
  for (Index i = 0; i < dx.count(); ++i) dx[i] = Vec3(direction(random), direction(random), direction(random));
  std::vector<double> j;
  field->cellField("J", x, j);
  elements = double(j.size());
  field->addForce(x, v, f);
}

double Body::invertedShare() const {
  std::vector<double> j;
  field->cellField("J", x, j);
  return double(std::count_if(j.begin(), j.end(), [](double value) { return value < 0; })) / double(j.size());
}

Body& bodyOf(const std::string& scene, const std::vector<std::string>& overrides, Shape shape) {
  library();  // made before what is kept, so destroyed after it
  static std::string kept_key;
  static std::unique_ptr<Body> kept;
  const std::string key = fmt::format("{} {} {}", scene, fmt::join(overrides, " "), int(shape));
  if (key != kept_key) {
    kept.reset();  // before the next one is made: large meshes need not exist twice
    kept_key.clear();
    kept = std::make_unique<Body>(scene, overrides, shape);
    kept_key = key;
  }
  return *kept;
}

}  // namespace stroma::bench
