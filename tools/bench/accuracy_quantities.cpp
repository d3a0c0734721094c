// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/bench/accuracy_quantities.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string_view>

namespace stroma::bench {
namespace {

/// Mean of `value(rest, displacement)` over the nodes that `where` chooses at rest.
template <class Where, class Value>
double meanOf(const Simulation& simulation, Where&& where, Value&& value) {
  const State& state = *simulation.states().at(0);
  double sum = 0;
  int count = 0;
  for (Index i = 0; i < state.size(); ++i)
    if (const Vec3& rest = state.rest_position[std::size_t(i)]; where(rest))
      sum += value(rest, Vec3(state.x()[i] - rest)), ++count;
  return sum / count;
}

/// The same of the displacement along an axis.
template <class Where>
double meanDisplacement(const Simulation& simulation, int axis, Where&& where) {
  return meanOf(simulation, where, [axis](const Vec3&, const Vec3& moved) { return moved[axis]; });
}

}  // namespace

double beamEnd(const Simulation& simulation) {
  return meanDisplacement(simulation, 1, [](const Vec3& p) { return p.x() > 0.2 - 1e-9; });
}

double cookCorner(const Simulation& simulation) {
  return meanDisplacement(simulation, 1, [](const Vec3& p) { return p.x() > 48 - 1e-6 && p.y() > 60 - 1e-6; });
}

double cubeBulge(const Simulation& simulation) {
  return meanDisplacement(simulation, 0, [](const Vec3& p) {
    return p.x() > 80 - 1e-6 && std::abs(p.y() - 40) < 1e-6 && std::abs(p.z() - 40) < 1e-6;
  });
}

double barTorque(const Simulation& simulation) {
  const System& system = *simulation.systems().at(0);
  const State& state = *simulation.states().at(0);
  Vector v(system.allRows()), force(system.allRows());
  for (ForceField* field : system.forceFields()) field->addForce(system.x, v, force);
  double torque = 0;
  for (Index i = 0; i < state.size(); ++i)
    if (state.rest_position[std::size_t(i)].z() < 1e-6)
      torque += Vec3(system.x[i]).cross(Vec3(force[state.firstRow() + i])).z();
  return std::abs(torque);
}

double blockTop(const Simulation& simulation) {
  return meanDisplacement(simulation, 2, [](const Vec3& p) { return p.z() > 40 - 1e-6; });
}

double chamberGrowth(const Simulation& simulation) {
  constexpr double inner = 10;
  return meanOf(simulation, [](const Vec3& p) { return p.norm() < inner + 1e-6; },
                [](const Vec3& rest, const Vec3& moved) { return (rest + moved).norm() - inner; });
}

double ventricleApex(const Simulation& simulation) {
  return -meanDisplacement(simulation, 2, [](const Vec3& p) { return std::hypot(p.x(), p.y()) < 1e-6 && p.z() > -17 - 1e-6; });
}

double muscleEnd(const Simulation& simulation) {
  return meanDisplacement(simulation, 2, [](const Vec3& p) { return (p - Vec3(10, 0.5, 1)).norm() < 1e-6; });
}

double middleOverEnd(const Simulation& simulation) {
  constexpr double length = 0.2;
  const auto at = [&](double x) {
    return meanDisplacement(simulation, 1, [x](const Vec3& p) { return std::abs(p.x() - x) < 1e-9; });
  };
  return at(length / 2) / at(length);
}

double columnDegree(const Simulation& simulation) {
  constexpr double drained = 1400, load = 0.01;
  double modulus = 0;
  for (const ForceField* field : simulation.systems().at(0)->forceFields())
    if (const Data* data = field->data().find("biotModulus")) modulus = std::stod(data->print());
  const double first = load / (drained + modulus), last = load / drained;
  const double way = -meanDisplacement(simulation, 2, [](const Vec3& p) { return p.z() > 1 - 1e-9; });
  return (way - first) / (last - first);
}

double legDent(const Simulation& simulation) {
  return meanDisplacement(simulation, 1, [](const Vec3& p) {
    return std::abs(p.x()) < 0.06 && p.y() > 0.02 && p.y() < 0.06 && p.z() > 0.15 && p.z() < 0.19;
  });
}

double organTip(const Simulation& simulation) {
  return meanDisplacement(simulation, 1, [](const Vec3& p) { return p.x() > 0.085; });
}

std::vector<Bead> readBeads(const std::string& file) {
  constexpr std::size_t columns = 15, at_rest = 3, pressed = 12;
  constexpr int header_lines = 7;
  std::ifstream stream(file);
  if (!stream) throw std::runtime_error(fmt::format("{}: it cannot be read", file));
  std::vector<Bead> beads;
  Vec3 middle = Vec3::Zero();
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    if (number <= header_lines || line.empty()) continue;
    std::vector<double> values;
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');) {
      char* end = nullptr;
      const double value = std::strtod(field.c_str(), &end);
      if (end == field.c_str() || std::string_view(end).find_first_not_of(" \r") != std::string_view::npos) break;
      values.push_back(value);
    }
    if (values.size() < columns)
      throw std::runtime_error(fmt::format("{}:{}: expected {} numbers of a bead", file, number, columns));
    const auto place = [&](std::size_t c) { return Vec3(values[c], values[c + 1], -values[c + 2]); };
    beads.push_back({place(at_rest), place(pressed)});
    middle += beads.back().rest;
  }
  if (beads.empty()) throw std::runtime_error(fmt::format("{}: it has no beads", file));
  middle /= double(beads.size());
  for (Bead& bead : beads) bead.rest -= middle, bead.pressed -= middle;
  return beads;
}

double beadDistance(const Simulation& simulation, const std::vector<Bead>& beads) {
  constexpr double edge = 80;
  const State& state = *simulation.states().at(0);
  const int cells = int(std::lround(std::cbrt(double(state.size())))) - 1;
  double sum = 0;
  for (const Bead& bead : beads) {
    int cell[3];
    double share[3];
    for (int a = 0; a < 3; ++a) {
      const double at = std::clamp(bead.rest[a] / edge + 0.5, 0.0, 1.0) * cells;
      cell[a] = std::min(int(at), cells - 1), share[a] = at - cell[a];
    }
    Vec3 moved = Vec3::Zero();
    for (int corner = 0; corner < 8; ++corner) {
      Index node = 0;
      double weight = 1;
      for (int a = 2; a >= 0; --a) {
        const int bit = corner >> a & 1;
        node = node * (cells + 1) + cell[a] + bit;
        weight *= bit ? share[a] : 1 - share[a];
      }
      moved += weight * (Vec3(state.x()[node]) - state.rest_position[std::size_t(node)]);
    }
    sum += (bead.rest + moved - bead.pressed).norm();
  }
  return sum / double(beads.size());
}

}  // namespace stroma::bench
