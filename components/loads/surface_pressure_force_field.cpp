// SPDX-License-Identifier: LGPL-2.1-or-later
// SurfacePressureForceField: a pressure on triangles and quads that follows them.
//
//   f_a = p A_a,   A_a = integral of N_a n dA,   E = -p V on a closed surface
//
// A cavity is inflated by a NEGATIVE pressure, and so is a body pressed from outside: a positive pressure pushes along the
// normals, which turn counter-clockwise around a face and point out of the material of a body, at the wall of a cavity
// into the cavity. A finger of `stroma mesh` whose hollow is blown up by 20 kPa:
//
//   <MeshGmshLoader name="loader" filename="finger.msh" group="finger.cavity"/>
//   <SurfacePressureForceField triangleIndices="@loader.groupTriangleIndices" pressure="-20 kPa"/>
//
// A closed surface oriented outward, such as a balloon, is inflated by a positive one. The forces are exact for triangles and
// for bilinear quads, warped or not. With quads="halves", as in SOFA, each quad is two triangles, which the tangent leaves
// out, and which mainDirection does not weigh. On a closed surface they have no resultant and no moment, and their work is p
// dV.
//
// Loaded are the listed triangles and quads; without lists all of the mesh but those between two of its volume cells, or
// the boundary of these when it lists no faces, that lie in the box from min to max in the rest shape (both corners, or
// neither for everywhere). With a mainDirection d of unit length a face of normal n at rest is loaded by |n.d| times
// the pressure.
//
// Over time the pressure is constant; or linear between keyTimes; or with pulseMode it starts at 0, moves to `pressure` at
// pressureSpeed, and then oscillates between pressureLowerBound and it. With volumeConservationMode it is that of a gas at
// constant temperature, p V_0/V, E = -p V_0 ln(V/V_0), constant below a thousandth of V_0. V_0 is defaultVolume, or for -1 the
// volume at rest. Its change with V, a stiffness between all nodes of the surface, is left out of the tangent.
//
// tangent: see the attribute. On an open surface whose rim can move the load has no potential.
//
// Source: the names and attributes are SOFA's, but keyTimes, keyPressures and tangent.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-10"/>
//   <MeshTopology position="0 0 0  1 0 0  1 1 0  0 1 0  0 0 1  1 0 1  1 1 1  0 1 1  0.5 0.5 1.5" edges="0 1  1 2  2 3
//       3 0  4 5  5 6  6 7  7 4  0 4  1 5  2 6  3 7  0 8  1 8  2 8  3 8  4 8  5 8  6 8  7 8  0 6  1 7"
//     triangles="4 5 8  5 6 8  6 7 8  7 4 8" quads="0 3 2 1  0 1 5 4  1 2 6 5  2 3 7 6  3 0 4 7"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="0.1"/>
//   <MeshSpringForceField linesStiffness="100"/>
//   <SurfacePressureForceField pressure="20" pulseMode="true" pressureSpeed="40"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "components/loads/surface_load.h"
#include "framework/mechanics/key_times.h"
#include "framework/mechanics/surface_selection.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// |p V_0/V| is limited to this times |p|.
constexpr double largest_compression = 1000;
/// How far mainDirection may be from unit length: that of a vector written with three digits.
constexpr double unit_tolerance = 2e-3;

class SurfacePressureForceField final : public SurfaceLoad {
 public:
  void declare(DataTable& table) override;
  void init() override;
  ForceTraits traits() const override {
    ForceTraits traits = SurfaceLoad::traits();
    traits.time_dependent = pulse_ || !key_times_.empty();
    return traits;
  }
  void setTime(double t) override { now_ = pressureAt(t); }
  double energy(ConstRows x) const override;

 protected:
  Mat3 stress(ConstRows x) const override;
  bool hasPotential() const override { return isClosed() && !isWeighted(); }

 private:
  bool isSet(const char* attribute) const { return data().find(attribute)->isSet(); }
  void checkTimes();
  void checkGas();
  void tellInnerFaces(const Mesh& mesh) const;
  std::vector<double> weightsOf(const std::vector<Face>& faces) const;
  static std::size_t splitQuads(std::vector<Face>& faces);
  double pressureAt(double t) const;
  double pulseAfter(long steps) const;

  double pressure_ = 0, lower_bound_ = 0, speed_ = 0, default_volume_ = -1;
  SurfaceSelection selection_;
  Vec3 main_direction_ = Vec3::Zero();
  std::vector<double> key_times_, key_pressures_;
  bool pulse_ = false, gas_ = false, use_tangent_ = true, exact_border_ = false, warn_of_inner_ = false;
  enum class Quads : int { bilinear, halves } quads_ = Quads::bilinear;
  enum class PulseSteps : int { none, end, start } pulse_steps_ = PulseSteps::none;
  KeyTimes<double> keys_;
  double now_ = 0;  ///< p [Pa]
};

void SurfacePressureForceField::declare(DataTable& table) {
  SurfaceLoad::declare(table);
  table.add("pressure", pressure_).recompiled().help("pressure along the normals").unit("Pa");
  selection_.declare(table);
  table.add("exactBorder", exact_border_).help("the box from min to max is not widened by 1e-9 of its size, as in SOFA");
  table.add("warnOfInnerFaces", warn_of_inner_)
      .help("a warning says where SOFA would also load triangles between two tetrahedra, which are not loaded here");
  table.add("mainDirection", main_direction_)
      .help("faces are loaded in proportion to the cosine of their normal with it; 0 0 0: all alike")
      .unit("-");
  table.addChoice("quads", quads_, {"bilinear", "halves"})
      .help("of quads the exact forces of a bilinear face, or (SOFA) those of its triangles 0 1 2 and 0 2 3, without a stiffness");
  table.add("pulseMode", pulse_).help("the pressure oscillates between pressureLowerBound and pressure");
  table.add("pressureLowerBound", lower_bound_).help("the other end of the pulse").unit("Pa");
  table.add("pressureSpeed", speed_).help("change of the pressure in pulseMode").unit("Pa/s").min(0);
  table.addChoice("pulseSteps", pulse_steps_, {"none", "end", "start"})
      .help(
          "none: the pulse is linear in time. end and start: it changes by pressureSpeed dt in each step and is cut off at its ends, as "
          "SOFA's; forces are evaluated at the end of a step, or at its start with the pressure of the end");
  table.add("keyTimes", key_times_)
      .help(
          "times, ascending; before the first and after the last the pressure is "
          "constant")
      .unit("s");
  table.add("keyPressures", key_pressures_).help("pressure at each of keyTimes, instead of pressure").unit("Pa");
  table.add("volumeConservationMode", gas_).help("the pressure goes with the inverse of the volume behind the surface");
  table.add("defaultVolume", default_volume_)
      .help("volume at which a gas has the given pressure; -1: the volume at rest")
      .unit("m^3");
  table.add("useTangentStiffness", use_tangent_).help("false: the load has no stiffness");
  table.addVisualOnly("drawForceScale");
}

void SurfacePressureForceField::init() {
  ForceField::init();
  checkTimes();
  std::vector<Face> faces = selection_.faces(*this, surfaceMesh(), state());
  if (warn_of_inner_) tellInnerFaces(surfaceMesh());
  const std::size_t halves = quads_ == Quads::halves ? splitQuads(faces) : 0;
  std::vector<double> weights = weightsOf(faces);
  if (!weights.empty()) std::fill_n(weights.rbegin(), halves, 1.);
  setFaces(std::move(faces), std::move(weights));
  rigid_faces = halves;
  has_tangent = use_tangent_;
  stress_is_fixed = !gas_;
  if (gas_) checkGas();
  now_ = pressureAt(0);
}

/// SOFA makes triangles of all faces of tetrahedra, one for both sides of an inner one, and loads those that the mesh has.
void SurfacePressureForceField::tellInnerFaces(const Mesh& mesh) const {
  const bool lists = isSet("triangleIndices") || isSet("quadIndices") || isSet("quadraticTriangleIndices");
  if (lists || mesh.tetrahedra.empty()) return;
  const auto sorted = [](Triangle face) {
    std::sort(face.begin(), face.end());
    return face;
  };
  std::set<Triangle> inner;
  for (const Triangle& face : mesh.triangularFaces()) inner.insert(sorted(face));
  for (const Triangle& face : mesh.boundaryTriangles()) inner.erase(sorted(face));
  Eigen::AlignedBox3d box;
  if (isSet("min"))
    for (const char* corner : {"min", "max"}) box.extend(**std::get_if<Vec3*>(&data().find(corner)->pointer()));
  const std::vector<Triangle> faces = mesh.triangles.empty() ? mesh.triangularFaces() : mesh.triangles;
  const auto is_loaded = [&](const Triangle& face) {
    return inner.contains(sorted(face)) && (box.isEmpty() || std::all_of(face.begin(), face.end(), [&](Index node) {
             return box.contains(state().rest_position[node]);
           }));
  };
  if (const auto count = std::count_if(faces.begin(), faces.end(), is_loaded))
    warn(fmt::format("loads the border of the tetrahedra; SOFA loads the faces between them too, {} here", count),
         "triangles of the border alone, as Tetra2TriangleTopologicalMapping lists them");
}

/// Two triangles for each quad, at the end of the list; how many they are.
std::size_t SurfacePressureForceField::splitQuads(std::vector<Face>& faces) {
  std::vector<Face> others, halves;
  for (const Face& face : faces) {
    const auto& n = face.nodes;
    if (face.corners != 4) {
      others.push_back(face);
      continue;
    }
    halves.push_back(Face(Triangle{n[0], n[1], n[2]}));
    halves.push_back(Face(Triangle{n[0], n[2], n[3]}));
  }
  faces = std::move(others);
  faces.insert(faces.end(), halves.begin(), halves.end());
  return halves.size();
}

void SurfacePressureForceField::checkTimes() {
  if (!pulse_)
    for (const char* name : {"pressureLowerBound", "pressureSpeed"})
      if (isSet(name))
        throw ComponentError(fmt::format("{} has no meaning without pulseMode", name), "pulseMode=\"1\"");
  if (key_times_.empty() != key_pressures_.empty())
    throw ComponentError("keyTimes and keyPressures are not given together", "both or none of them");
  if (!key_times_.empty()) {
    if (pulse_ || isSet("pressure"))
      throw ComponentError("keyPressures are given with pressure or pulseMode", "one of them");
    keys_.assign(key_times_, key_pressures_, "keyTimes", "keyPressures");
    keys_.check();
    return;
  }
  if (pressure_ == 0) warn("the pressure is zero: the component has no effect", "pressure or keyPressures");
  if (!pulse_) return;
  if (!isSet("pressureSpeed")) {
    speed_ = std::abs(pressure_);
    warn(fmt::format("pressureSpeed is not given: {:g} Pa/s, `pressure` in one second", speed_));
  }
  if (!(speed_ > 0)) throw ComponentError("pressureSpeed is zero", "a positive number");
}

void SurfacePressureForceField::checkGas() {
  if (!isClosed())
    throw ComponentError(
        fmt::format("volumeConservationMode needs a volume, and the loaded surface is open at the edge "
                    "of nodes {}",
                    openEdge()),
        "a closed surface");
  if (isWeighted()) throw ComponentError("volumeConservationMode and mainDirection are both given", "one of them");
  if (default_volume_ == -1) {
    default_volume_ = restVolume();
    if (!(default_volume_ > 0))
      throw ComponentError(fmt::format("the volume behind the surface is {:g} at rest", default_volume_),
                           "normals that point outward");
  }
  if (!(default_volume_ > 0))
    throw ComponentError(fmt::format("defaultVolume is {:g}", default_volume_), "a positive volume, or -1");
}

std::vector<double> SurfacePressureForceField::weightsOf(const std::vector<Face>& faces) const {
  std::vector<double> weights;
  if (main_direction_.isZero(0)) return weights;
  if (const double length = main_direction_.norm(); !(std::abs(length - 1) < unit_tolerance)) {
    const Vec3 unit = main_direction_ / length;
    throw ComponentError(fmt::format("mainDirection has the length {:g}, which would multiply the pressure", length),
                         "a vector of length 1",
                         fmt::format("mainDirection=\"{:.6g} {:.6g} {:.6g}\"", unit.x(), unit.y(), unit.z()));
  }
  for (const Face& face : faces) {
    area_vectors::Corners at;
    for (std::size_t a = 0; a < at.size(); ++a) at[a] = state().rest_position[face.nodes[a]];
    const area_vectors::Corners areas = area_vectors::of(at, face.corners);
    const Vec3 normal = std::accumulate(areas.begin(), areas.end(), Vec3(Vec3::Zero()));
    weights.push_back(std::abs(normal.normalized().dot(main_direction_)));
  }
  return weights;
}

double SurfacePressureForceField::pressureAt(double t) const {
  if (!key_times_.empty()) return keys_.at(t);
  if (!pulse_) return pressure_;
  if (pulse_steps_ != PulseSteps::none)
    return pulseAfter(std::lround((t - node().root().root_time) / node().dt()) + (pulse_steps_ == PulseSteps::start));
  const double way = speed_ * std::max(t, 0.), first = std::abs(pressure_), swing = pressure_ - lower_bound_;
  if (way <= first) return std::copysign(way, pressure_);
  if (swing == 0) return pressure_;
  const double turns = std::fmod((way - first) / std::abs(swing), 2.);
  return pressure_ - swing * (turns < 1 ? turns : 2 - turns);
}

/// From zero up, and then down and up between the ends, by as many steps each.
double SurfacePressureForceField::pulseAfter(long steps) const {
  const double high = pressure_ > 0 ? pressure_ : lower_bound_, low = pressure_ > 0 ? lower_bound_ : pressure_;
  const double change = speed_ * node().dt();
  constexpr double grace = 1e-9;  // of a step
  const auto count = [change](double way) { return std::max(1L, std::lround(std::ceil(way / change - grace))); };
  const long first = count(high), swing = count(high - low);
  if (steps < first) return double(steps) * change;
  const long since = (steps - first) % (2 * swing);
  return since <= swing ? std::max(high - double(since) * change, low) : std::min(low + double(since - swing) * change, high);
}

Mat3 SurfacePressureForceField::stress(ConstRows x) const {
  const double factor =
      gas_ ? std::min(largest_compression, default_volume_ / std::max(volume(x), 1e-9 * default_volume_)) : 1;
  return now_ * factor * Mat3::Identity();
}

double SurfacePressureForceField::energy(ConstRows x) const {
  if (!hasPotential()) return 0;
  const double v = volume(x);
  if (!gas_) return -now_ * v;
  // beyond the limit of the pressure linear in V
  const double ratio = v / default_volume_, least = 1 / largest_compression;
  return -now_ * default_volume_ * (ratio >= least ? std::log(ratio) : std::log(least) + ratio / least - 1);
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(surface_pressure_force_field) {
  factory.add<stroma::SurfacePressureForceField>("SurfacePressureForceField",
                                                 "a pressure on triangles and quads that follows them");
}
