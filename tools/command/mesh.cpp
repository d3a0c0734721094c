// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma mesh: a tetrahedral mesh from a segmented image or a closed surface.
#include <fmt/format.h>

#include <Eigen/LU>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "framework/mesh/mesh_loader.h"
#include "framework/scene/output_file.h"
#include "framework/scene/services.h"
#include "tools/command/mesh_report.h"
#include "tools/mesh/enclosed_volume.h"
#include "tools/mesh/voxels.h"
#include "tools/session/file_uses.h"

namespace stroma::command {
namespace {

/// Sizes that were not given, from the longest side of the body.
void completeSizes(MeshCriteria& criteria, double longest_side, const std::vector<int>& labels) {
  if (!(criteria.cell_size > 0)) criteria.cell_size = longest_side / 20;
  if (criteria.distance >= longest_side)
    throw UsageError(fmt::format("--distance {:g}: the longest side of the body is {:.3g}, so that nothing of its shape would be left "
                                 "(expected less than a cell's size; lengths are in metres with --unit, else as --scale makes them)",
                                 criteria.distance, longest_side));
  if (criteria.distance > 0) return;
  double smallest = std::numeric_limits<double>::infinity();
  for (const int label : labels) smallest = std::min(smallest, criteria.sizeOf(label));
  criteria.distance = smallest / 10;
}

class StageClock {
 public:
  double seconds() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double>(now - std::exchange(start_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// A line on standard error every few seconds, as long as it lives.
class Heartbeat {
 public:
  Heartbeat(double seconds, double expected_cells) {
    thread_ = std::thread([this, seconds, expected_cells] {
      std::unique_lock lock(mutex_);
      const auto start = std::chrono::steady_clock::now();
      while (!woken_.wait_for(lock, std::chrono::duration<double>(seconds), [this] { return done_; })) {
        const std::chrono::duration<double> gone = std::chrono::steady_clock::now() - start;
        fmt::print(stderr, "meshing since {:.2g} s, about {:.2g} cells expected\n", gone.count(), expected_cells);
      }
    });
  }
  Heartbeat(const Heartbeat&) = delete;
  Heartbeat& operator=(const Heartbeat&) = delete;
  ~Heartbeat() {
    {
      const std::lock_guard lock(mutex_);
      done_ = true;
    }
    woken_.notify_one();
    thread_.join();
  }

 private:
  std::mutex mutex_;
  std::condition_variable woken_;
  bool done_ = false;
  std::thread thread_;
};

/// Of a label: what decides how many cells it takes.
struct Extent {
  double volume = 0, area = 0;
};

/// Roughly, to a factor of two: a tetrahedron whose sphere has the radius s fills about s^3 / 7, and a triangle of
/// size s on the boundary brings about four cells for each s^2. A small distance on a curved surface brings more.
double expectedCells(const MeshCriteria& criteria, const std::map<int, Extent>& labels) {
  double cells = 0;
  for (const auto& [label, extent] : labels) {
    const double size = criteria.sizeOf(label), facet = criteria.facet_size > 0 ? criteria.facet_size : size;
    cells += 7 * extent.volume / std::pow(size, 3) + 4 * extent.area / (facet * facet);
  }
  return cells;
}

void refuseTooMany(const MeshRequest& request, double cells, const Vec3& box) {
  if (cells <= request.most_cells) return;
  throw ComponentError(
      fmt::format("about {:.1e} cells are to be expected, more than --most-cells {:.2g}: the body's box is {:.4g} x "
                  "{:.4g} x {:.4g} with --scale {:.4g}, and the cell size {:.4g}",
                  cells, request.most_cells, box.x(), box.y(), box.z(), request.scale, request.criteria.cell_size),
      "lengths in one unit (--unit mm takes millimetres to metres), or larger cells");
}

/// Volume and area of each label; a stair of voxels has about 1.5 times the area of what it stands for.
std::map<int, Extent> extentsOf(const LabelImage& image) {
  std::map<int, Extent> extents;
  const std::array<std::size_t, 3> stride{1, std::size_t(image.size[0]),
                                          std::size_t(image.size[0]) * std::size_t(image.size[1])};
  const std::vector<long> voxels = image.voxels();
  for (std::size_t i = 0; i < voxels.size(); ++i)
    extents[image.values[i]].volume = double(voxels[i]) * image.voxelVolume();
  for (std::size_t k = 0; k < 3; ++k) {
    const double face = image.voxelVolume() / image.steps.col(Eigen::Index(k)).norm() / 1.5;
    std::vector<long> count(image.values.size() + 1, 0);
    for (std::size_t v = 0; v < image.region.size(); ++v) {
      const std::uint8_t own = image.region[v];
      const Index along = Index(v / stride[k] % std::size_t(image.size[k]));
      const std::uint8_t next = along + 1 < image.size[k] ? image.region[v + stride[k]] : std::uint8_t(0);
      if (own != next) ++count[own], ++count[next];
      if (along == 0 && own) ++count[own];
    }
    for (std::size_t i = 0; i < image.values.size(); ++i) extents[image.values[i]].area += face * double(count[i + 1]);
  }
  return extents;
}

/// The parts of the image; one is meshed when a point in a cell of its label lies in one of its voxels.
std::vector<ImagePart> partsOf(const LabelImage& image, const LabelledMesh& mesh) {
  const ConnectedParts connected = connectedParts(image.size, image.region);
  const Mat3 inverse = image.steps.inverse();
  const std::size_t nx = std::size_t(image.size[0]), ny = std::size_t(image.size[1]);
  std::vector<ImagePart> parts;
  for (std::size_t p = 0; p < connected.first.size(); ++p) {
    const std::size_t voxel = connected.first[p];
    const Vec3 at(double(voxel % nx), double(voxel / nx % ny), double(voxel / nx / ny));
    parts.push_back(
        {image.values[image.region[voxel] - 1], connected.voxels[p], image.origin + image.steps * at, false});
  }
  const auto visit = [&](const Vec3& point, int label) {
    const Vec3 u = (inverse * (point - image.origin)).array().round();
    for (int k = 0; k < 3; ++k)
      if (!(u[k] >= 0 && u[k] < image.size[k])) return;
    const Index part = connected.part[std::size_t(u[0]) + nx * (std::size_t(u[1]) + ny * std::size_t(u[2]))];
    if (part >= 0 && parts[part].label == label) parts[part].meshed = true;
  };
  for (std::size_t c = 0; c < mesh.tetrahedra.size(); ++c) {
    Vec3 centre = Vec3::Zero();
    for (const Index n : mesh.tetrahedra[c]) centre += mesh.position[n] / 4;
    visit(centre, mesh.labels[c]);
    for (const Index n : mesh.tetrahedra[c]) visit((centre + mesh.position[n]) / 2, mesh.labels[c]);
  }
  return parts;
}

Meshed meshVoxels(MeshRequest& request, const LabelImage& image, StageClock& clock) {
  Meshed out;
  checkLabels(request, image.values);
  completeSizes(request.criteria, image.bodySize().maxCoeff(), image.values);
  const std::map<int, Extent> extents = extentsOf(image);
  for (const auto& [label, extent] : extents) out.wanted[label] = extent.volume;
  out.expected_cells = expectedCells(request.criteria, extents);
  refuseTooMany(request, out.expected_cells, image.bodySize());
  out.voxel = image.smallestSpacing();
  out.read_seconds = clock.seconds();
  const Heartbeat heartbeat(request.progress, out.expected_cells);
  out.mesh = service<MeshGenerator>()->fromImage(image, request.criteria, out.match);
  out.parts = partsOf(image, out.mesh);
  out.mesh_seconds = clock.seconds();
  return out;
}

Meshed meshImage(MeshRequest& request) {
  StageClock clock;
  LabelImage image = readLabelImage(request.input);
  image.origin *= request.scale, image.steps *= request.scale;
  return meshVoxels(request, image, clock);
}

/// The surface, through the loader of its format.
Mesh readSurface(const MeshRequest& request, const char* loader) {
  if (!fs::exists(request.input)) throw ComponentError(fmt::format("there is no file {}", request.input));
  Factory factory;
  Modules modules(factory);
  SceneDescription description;
  description.file = "stroma mesh";
  const SourceLocation where{description.file};
  description.root.where = where;
  description.root.components.push_back({loader,
                                         {{"name", "surface", where},
                                          {"filename", fs::absolute(request.input).string(), where},
                                          {"triangulate", "true", where},
                                          {"scale", fmt::format("{}", request.scale), where}},
                                         where,
                                         {}});
  const Scene scene = instantiate(std::move(description), factory, modules);
  std::vector<MeshLoader*> loaders;
  scene.root->collect(loaders);
  return Mesh(loaders.at(0)->mesh());
}

/// The inside of a surface that may cut itself.
Meshed meshFilled(MeshRequest& request, const Mesh& surface, StageClock& clock) {
  const Voxels filled = voxelsInside(surface.position, surface.triangles, request.voxels);
  if (filled.covered + filled.reversed > 0)
    fmt::print(
        stderr,
        "note: the surface overlaps itself: {} voxels are enclosed more than once and used once, {} are enclosed with reversed "
        "orientation and taken as outside; {} are inside\n",
        filled.covered, filled.reversed, filled.image.voxels()[0]);
  return meshVoxels(request, filled.image, clock);
}

Meshed meshSurface(MeshRequest& request) {
  StageClock clock;
  Meshed out;
  const Mesh surface = readSurface(request, request.surfaceLoader());
  if (surface.triangles.empty())
    throw ComponentError(fmt::format("{} has no triangles", request.input), "a closed surface");
  if (request.voxels > 0) return meshFilled(request, surface, clock);
  checkLabels(request, {1});
  const MeshReport report = surface.report();
  const Vec3 box = report.high - report.low;
  completeSizes(request.criteria, box.maxCoeff(), {1});
  if (const auto enclosed = enclosedBy(surface.position, surface.triangles)) {  // else the generator says what is wrong
    out.wanted[1] = enclosed->volume;
    out.expected_cells = expectedCells(request.criteria, {{1, {enclosed->volume, enclosed->area}}});
    refuseTooMany(request, out.expected_cells, box);
  }
  out.read_seconds = clock.seconds();
  const Heartbeat heartbeat(request.progress, out.expected_cells);
  out.mesh = service<MeshGenerator>()->fromSurface(surface.position, surface.triangles, request.criteria);
  out.mesh_seconds = clock.seconds();
  return out;
}

int mesh(const Arguments& arguments) {
  std::optional<MeshRequest> request = readMeshRequest(arguments);
  if (!request) return exit_done;
  if (const auto sentence = overwriting({{request->output, "-o"}}, {{request->input, "stroma mesh"}}))
    throw UsageError(*sentence);
  checkWritable(request->output, true);
  const Meshed meshed = request->surfaceLoader() ? meshSurface(*request) : meshImage(*request);
  const MeshQuality quality = qualityOf(meshed.mesh);
  writeWholeFile(request->output, request->toVtu()
                                      ? vtuText(meshed.mesh, request->order)
                                      : gmshText(meshed.mesh, request->names, request->format_22, request->order));
  warnOfMesh(*request, meshed, quality);
  printMeshReport(*request, meshed, quality);
  return exit_done;
}

}  // namespace

const Subcommand mesh_command{"mesh", "make a tetrahedral mesh from a segmented image or a closed surface",
                              Group::scenes, mesh, meshLine};

}  // namespace stroma::command
