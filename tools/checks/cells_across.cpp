// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/checks/cells_across.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "framework/mechanics/open_choices.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_kind.h"
#include "framework/mesh/cell_tables.h"

namespace stroma {
namespace {

constexpr std::size_t most_cells = 100000, most_lines = 400;

struct CellFace {
  Index cell = 0;
  int face = 0;  ///< of CellKind::faces
};
struct Side {
  std::array<Index, 4> sorted;  ///< nodes; -1 for the fourth of a triangle
  CellFace at;
  CellFace across;  ///< the cell on the other side; -1: none
};

const CellKind& volumeKindOf(const Hexahedron&) { return cell_kinds::hexahedron; }
const CellKind& volumeKindOf(const Tetrahedron&) { return cell_kinds::tetrahedron; }

/// Sides in the order of cells and faces.
template <class Cell>
std::vector<Side> sidesOf(const std::vector<Cell>& cells, int faces) {
  std::vector<Side> sides;
  sides.reserve(cells.size() * std::size_t(faces));
  for (std::size_t c = 0; c < cells.size(); ++c)
    for (int f = 0; f < faces; ++f) {
      Side side{{-1, -1, -1, -1}, {Index(c), f}, {-1, -1}};
      const std::size_t corners = cells[c].size() == 4 ? 3 : 4;
      for (std::size_t i = 0; i < corners; ++i)
        side.sorted[i] = cells[c][std::size_t(volumeKindOf(cells[c]).faces[std::size_t(f)].nodes[i])];
      std::sort(side.sorted.begin(), side.sorted.end());
      sides.push_back(side);
    }
  std::vector<std::size_t> order(sides.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return sides[a].sorted < sides[b].sorted; });
  for (std::size_t i = 0; i + 1 < order.size(); ++i) {
    Side &a = sides[order[i]], &b = sides[order[i + 1]];
    if (a.sorted == b.sorted) {
      a.across = b.at;
      b.across = a.at;
      ++i;
    }
  }
  return sides;
}

struct Line {
  double length, cells;
  double step = 0;  ///< length of its first cell along the body
};

Vec3 middle(const Side& side, const std::vector<Vec3>& position) {
  Vec3 sum = Vec3::Zero();
  int count = 0;
  for (const Index n : side.sorted)
    if (n >= 0) sum += position[n], ++count;
  return sum / count;
}

/// The side of the same hexahedron that has no node in common with this one.
const Side* oppositeOf(const Side& side, const std::vector<Side>& sides) {
  for (std::size_t f = 0; f < 6; ++f) {
    const Side& other = sides[std::size_t(side.at.cell) * 6 + f];
    if (std::none_of(other.sorted.begin(), other.sorted.end(), [&](Index n) {
          return std::find(side.sorted.begin(), side.sorted.end(), n) != side.sorted.end();
        }))
      return &other;
  }
  return nullptr;
}

/// How far cells go on from a side of one, out of it. A ring has no end.
double reachFrom(const Side& side, const std::vector<Side>& sides, const std::vector<Vec3>& position) {
  constexpr int most = 500;
  const Side* out = &side;
  for (int count = 0; count < most; ++count) {
    if (out->across.cell < 0) return (middle(*out, position) - middle(side, position)).norm();
    out = oppositeOf(sides[std::size_t(out->across.cell) * 6 + std::size_t(out->across.face)], sides);
    if (!out) return 0;
  }
  return std::numeric_limits<double>::infinity();
}

/// Length of the cell of a side along the one of its two other directions in which the body goes farther.
double stepAlong(const Side& start, const std::vector<Hexahedron>&, const std::vector<Side>& sides, const std::vector<Vec3>& position) {
  const Side* back = oppositeOf(start, sides);
  double farthest = 0, step = 0;
  for (std::size_t f = 0; back && f < 6; ++f) {
    const Side& side = sides[std::size_t(start.at.cell) * 6 + f];
    if (side.at.face == start.at.face || side.at.face == back->at.face) continue;
    const Side* other = oppositeOf(side, sides);
    if (!other) return 0;
    const double own = (middle(side, position) - middle(*other, position)).norm();
    const double reach = own + reachFrom(side, sides, position) + reachFrom(*other, sides, position);
    if (reach > farthest) farthest = reach, step = own;
  }
  return step;
}
double stepAlong(const Side&, const std::vector<Tetrahedron>&, const std::vector<Side>&, const std::vector<Vec3>&) { return 0; }

/// Through opposite faces.
Line lineFrom(const Side& start, const std::vector<Hexahedron>& cells, const std::vector<Side>& sides,
              const std::vector<Vec3>& position) {
  const Side* side = &start;
  double count = 0;
  while (count < double(cells.size())) {
    ++count;
    const Side* opposite = oppositeOf(*side, sides);
    if (!opposite) return {0, 0};
    if (opposite->across.cell < 0) return {(middle(*opposite, position) - middle(start, position)).norm(), count};
    side = &sides[std::size_t(opposite->across.cell) * 6 + std::size_t(opposite->across.face)];
  }
  return {0, 0};
}

/// Along the normal; a cell counts with the cube root of six times its volume, the edge of the cube that six such fill.
Line lineFrom(const Side& start, const std::vector<Tetrahedron>& cells, const std::vector<Side>& sides,
              const std::vector<Vec3>& position) {
  const auto plane = [&](const Side& side) -> Vec3 {
    const Vec3 a = position[side.sorted[1]], b = position[side.sorted[2]], c = position[side.sorted[3]];
    return Vec3((b - a).cross(c - a)).normalized();
  };
  const auto centre = [&](Index cell) -> Vec3 {
    Vec3 sum = Vec3::Zero();
    for (const Index n : cells[std::size_t(cell)]) sum += position[n] / 4;
    return sum;
  };
  const auto triangleMiddle = [&](const Side& side) { return middle(side, position); };
  const Vec3 origin = triangleMiddle(start);
  Vec3 inward = plane(start);
  if (inward.dot(centre(start.at.cell) - origin) < 0) inward = -inward;
  CellFace at = start.at;
  double reached = 0, size = 0, count = 0;
  while (count < double(cells.size())) {
    const Tetrahedron& cell = cells[std::size_t(at.cell)];
    const Vec3 corner = position[cell[0]];
    size += std::cbrt(
        std::abs((position[cell[1]] - corner).cross(position[cell[2]] - corner).dot(position[cell[3]] - corner)));
    ++count;
    const Side* out = nullptr;
    double nearest = std::numeric_limits<double>::infinity();
    for (int f = 0; f < 4; ++f) {
      if (f == at.face) continue;
      const Side& side = sides[std::size_t(at.cell) * 4 + std::size_t(f)];
      Vec3 normal = plane(side);
      const Vec3 point = triangleMiddle(side);
      if (normal.dot(point - centre(at.cell)) < 0) normal = -normal;
      const double rate = normal.dot(inward);
      if (rate <= 1e-9) continue;
      const double along = normal.dot(point - origin) / rate;
      if (along < nearest) {
        nearest = along;
        out = &side;
      }
    }
    if (!out) return {0, 0};
    reached = std::max(reached, nearest);
    if (out->across.cell < 0) return {reached, reached / (size / count)};
    at = out->across;
  }
  return {0, 0};
}

double median(std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto at = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Of short lines the one that a share of them does not exceed in cells. Counts of tetrahedra scatter around that of a
/// wall; those of hexahedra are exact, so that a quarter of the lines shows the walls of a hollow body.
Line thinnest(std::vector<Line>& lines, bool hexahedra) {
  if (lines.empty()) return {0, 0};
  const auto at = lines.begin() + std::ptrdiff_t(lines.size() / (hexahedra ? 4 : 2));
  std::nth_element(lines.begin(), at, lines.end(), [](const Line& a, const Line& b) { return a.cells < b.cells; });
  return *at;
}

/// Whether a side faces along an axis.
bool facesAlong(const Side& side, const std::vector<Vec3>& position, const Vec3& axis) {
  const Vec3 a = position[side.sorted[1]], b = position[side.sorted[2]], c = position[side.sorted[3]];
  const Vec3 normal = (b - a).cross(c - a);
  return std::abs(normal.dot(axis)) > 0.9 * normal.norm();
}

template <class Cell>
Slenderness measure(const std::vector<Cell>& cells, const std::vector<Vec3>& position, const Vec3& held) {
  Slenderness out;
  if (cells.empty() || cells.size() > most_cells) return out;
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Cell& cell : cells)
    for (const Index n : cell) low = low.cwiseMin(position[n]), high = high.cwiseMax(position[n]);
  out.extent = (high - low).maxCoeff();
  const std::vector<Side> sides = sidesOf(cells, int(volumeKindOf(cells[0]).faces.size()));
  std::vector<const Side*> boundary;
  for (const Side& side : sides)
    if (side.across.cell < 0 && !facesAlong(side, position, held)) boundary.push_back(&side);
  if (boundary.empty()) return out;
  const std::size_t stride = std::max<std::size_t>(1, boundary.size() / most_lines);
  std::vector<double> lengths;
  std::vector<Line> short_lines;
  for (std::size_t i = 0; i < boundary.size(); i += stride) {
    Line line = lineFrom(*boundary[i], cells, sides, position);
    if (!(line.cells > 0)) continue;
    lengths.push_back(line.length);
    if (line.length >= 0.3 * out.extent) continue;
    line.step = stepAlong(*boundary[i], cells, sides, position);
    short_lines.push_back(line);
  }
  out.typical = median(lengths);
  const Line thin = thinnest(short_lines, std::tuple_size_v<Cell> == 8);
  out.thickness = thin.length, out.cells = thin.cells;
  std::vector<double> steps;  // of lines like the thin one
  for (const Line& line : short_lines)
    if (line.cells == thin.cells && line.length < 1.2 * thin.length) steps.push_back(line.step / line.length);
  out.step = median(steps);
  return out;
}

}  // namespace

Slenderness slenderness(const std::vector<Hexahedron>& cells, const std::vector<Vec3>& position, const Vec3& held) {
  return measure(cells, position, held);
}
Slenderness slenderness(const std::vector<Tetrahedron>& cells, const std::vector<Vec3>& position, const Vec3& held) {
  return measure(cells, position, held);
}

std::string tooCoarseForBending(const Slenderness& body, bool hexahedra, const BendingLaw& law) {
  constexpr double share_tetrahedra = 3, limit = 0.03;  // measured on cantilevers under their weight of 4 and 8 cubes over the height
  if (!body.isSlender() || !(body.cells > 0) || law.has_incompatible_modes) return {};
  const double nu = law.poisson_ratio, n = body.cells, shear = 1 / (2 * (1 + nu));
  const double volume = law.has_mean_dilatation ? 0 : 1.1 * nu * nu / (1 - 2 * nu);
  const double cubes = hexahedra ? shear + volume : share_tetrahedra;  // times 1 / n^2
  const bool is_known = hexahedra && body.step > 0;
  const double error = is_known ? shear * body.step * body.step + volume / (n * n) : cubes / (n * n);
  if (error < limit) return {};
  const bool are_long = is_known && body.step * n > 1.5;
  return fmt::format(
      "{:.2g} {} lie over a thickness of {:.3g} in a body of {:.3g}{}: coarse for bending, where it is some {:.0f} % too "
      "stiff. {} over the thickness{} are within 3 %{}{}",
      n, hexahedra ? "hexahedra" : "tetrahedra", body.thickness, body.extent,
      are_long ? fmt::format(", and are {:.3g} long", body.step * body.thickness) : "", 100 * error / (1 + error),
      std::ceil(std::sqrt(cubes / limit)), are_long ? ", as long as high," : "",
      hexahedra ? "" : "; so are fewer hexahedra, which bend better",
      hexahedra && law.may_have_them ? "; where edges are parallel these bend far better with incompatibleModes=\"true\"" : "");
}

bool hasMeanDilatation(const ForceField& field) {
  const Data* dilatation = field.data().find("dilatation");
  const auto* open = dynamic_cast<const OpenChoices*>(&field);
  return dilatation && (dilatation->print() == "mean" || (open && open->choice().find("mean") != std::string::npos));
}

bool hasIncompatibleModes(const ForceField& field) {
  const Data* modes = field.data().find("incompatibleModes");
  return modes && modes->print() == "true";
}

/// An axis along which every node of a state is held, or zero.
static Vec3 heldAxis(const System& system, const State& state) {
  const ConstraintSet& constraints = system.constraints();
  if (constraints.change() || state.rows_per_node != 1 || state.firstRow() >= system.independentRows()) return Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    Index held = 0;
    for (Index row = state.firstRow(); held < state.size(); ++row, ++held) {
      const Index at = constraints.projectorOf(row);
      if (at < 0 || !constraints.projectors()[std::size_t(at)].projector.col(axis).isZero(0)) break;
    }
    if (held == state.size()) return Vec3::Unit(axis);
  }
  return Vec3::Zero();
}

const CellKind* kindOfLaw(const ForceField& field) {
  constexpr const char* stress = "vonMises";
  const std::vector<std::string> known = field.cellFields();
  return std::find(known.begin(), known.end(), stress) == known.end() ? nullptr : field.cellFieldShape(stress).kind;
}

/// A clause where `dilatation` is left open and Poisson's ratio is near that from which it is another: what is left open in a fit or a
/// sweep is then no smooth function of it. A mean leaves the volume change of bending within a cell without energy.
static std::string jumpOfDilatation(const ForceField& field, const Slenderness& body, bool hexahedra) {
  constexpr double near = 0.05;
  const Data *dilatation = field.data().find("dilatation"), *ratio = field.data().find("poissonRatio");
  const bool elastic = field.data().find("method");  // hyperelastic tetrahedra have no mean, and may have no ratio
  if (!dilatation || !ratio || dilatation->print() != "auto" || !(elastic || (hexahedra && ratio->isSet()))) return {};
  const double from = hexahedra ? 0.4 : 0.45;
  std::istringstream values(ratio->print());
  double largest = 0;
  for (double value = 0; values >> value;) largest = std::max(largest, value);
  if (!(std::abs(largest - from) <= near)) return {};
  // measured on cantilevers four times as long as high, of 1, 2 and 4 cells over the height: 125, 20 and 6 %; of tetrahedra 125, 90 and
  // 40 % with six in each cube, with five 18, 21 and 8 %
  const double n2 = body.cells * body.cells;
  const double jump = hexahedra ? 0.8 / n2 * (1 + 0.5 / n2) : 9.6 / (n2 + 6.7);
  return fmt::format("; with dilatation=\"auto\" it bends by {} {:.0f} % more from Poisson's ratio {:g} on, where cells take a mean "
                     "volume change: write \"local\" or \"mean\" where the ratio is varied",
                     hexahedra ? "some" : "up to", 100 * jump, from);
}

static bool mayHaveIncompatibleModes(const ForceField& field) {
  const auto is = [&](const char* name, const char* word) {
    const Data* data = field.data().find(name);
    return data && data->print() == word;
  };
  return is("incompatibleModes", "false") && is("updateStiffnessMatrix", "false") && is("polarOf", "gradient") &&
         !is("method", "green") && !is("method", "green_lagrange");
}

static BendingLaw bendingLawOf(const ForceField& field) {
  BendingLaw law{.has_mean_dilatation = hasMeanDilatation(field),
                 .has_incompatible_modes = hasIncompatibleModes(field),
                 .may_have_them = mayHaveIncompatibleModes(field)};
  const Data* ratio = field.data().find("poissonRatio");
  const auto* list = ratio ? std::get_if<std::vector<double>*>(&ratio->pointer()) : nullptr;
  if (list && !(*list)->empty()) law.poisson_ratio = *std::max_element((*list)->begin(), (*list)->end());
  return law;
}

/// Cells of the kind of its law, in a mesh of its state.
static std::string coarsenessOf(const ForceField& field, const CellKind& kind, const Vec3& held) {
  const std::vector<Vec3>& rest = field.state().rest_position;
  for (const Topology* topology : topologiesOf(field.state())) {
    const Mesh& mesh = topology->mesh();
    if (mesh.overlap != 1 || std::size_t(mesh.nodes()) > rest.size()) continue;
    const bool hexahedra = kind.type == CellType::hexahedron && !mesh.hexahedra.empty();
    if (!hexahedra && (kind.type != CellType::tetrahedron || mesh.tetrahedra.empty())) continue;
    const Slenderness body = hexahedra ? slenderness(mesh.hexahedra, rest, held) : slenderness(mesh.tetrahedra, rest, held);
    const std::string coarse = tooCoarseForBending(body, hexahedra, bendingLawOf(field));
    return coarse.empty() ? coarse : coarse + jumpOfDilatation(field, body, hexahedra);
  }
  return {};
}

void noteCoarseCells(const Simulation& simulation, Diagnostics& diagnostics) {
  for (const auto& system : simulation.systems())
    for (const ForceField* field : system->forceFields()) {
      const CellKind* kind = kindOfLaw(*field);
      if (!kind) continue;
      if (const std::string coarse = coarsenessOf(*field, *kind, heldAxis(*system, field->state())); !coarse.empty())
        diagnostics.note(field->where(), field->path(), coarse);
    }
}

}  // namespace stroma
