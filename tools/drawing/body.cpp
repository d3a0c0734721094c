// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/drawing/body.h"

#include <algorithm>
#include <limits>
#include <map>

#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_lists.h"
#include "tools/drawing/beams.h"
#include "tools/drawing/contacts.h"

namespace stroma::drawing {
namespace {

/// Numbers of the state until renumber().
void addTriangle(Body& body, Index a, Index b, Index c, Index owner) {
  body.triangles.push_back({a, b, c});
  body.owner.push_back(owner);
}

void addQuad(Body& body, const Quad& quad, Index owner) {
  addTriangle(body, quad[0], quad[1], quad[2], owner);
  addTriangle(body, quad[0], quad[2], quad[3], owner);
}

template <class Face>
void addEdges(std::vector<Edge>& edges, const std::vector<Face>& faces) {
  for (const Face& face : faces)
    for (std::size_t i = 0; i < face.size(); ++i) {
      const Index a = face[i], b = face[(i + 1) % face.size()];
      edges.push_back({std::min(a, b), std::max(a, b)});
    }
}

void makeUnique(std::vector<Edge>& edges) {
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
}

/// Four triangles of the six nodes, which follow the curve.
void addQuadratic(Body& body, const QuadraticTriangle& face, Index owner) {
  addTriangle(body, face[0], face[3], face[5], owner);
  addTriangle(body, face[3], face[1], face[4], owner);
  addTriangle(body, face[5], face[4], face[2], owner);
  addTriangle(body, face[3], face[4], face[5], owner);
}

void addEdges(std::vector<Edge>& edges, const std::vector<QuadraticTriangle>& faces) {
  for (const QuadraticTriangle& face : faces)
    for (const auto& [i, j] : cell_kinds::quadratic_triangle.edges)
      edges.push_back(
          {std::min(face[std::size_t(i)], face[std::size_t(j)]), std::max(face[std::size_t(i)], face[std::size_t(j)])});
}

/// The volume cells around each node, numbered as their lists follow each other.
struct CellsAround {
  std::vector<std::vector<Index>> of_node;

  explicit CellsAround(const Mesh& mesh) : of_node(std::size_t(mesh.nodes())) {
    Index number = 0;
    forEachCellList(
        [&](const CellKind& kind, const auto& cells) {
          for (std::size_t c = 0; kind.dimension == 3 && c < cells.size(); ++c, ++number)
            for (const Index node : cells[c]) of_node[std::size_t(node)].push_back(number);
        },
        mesh);
  }
  /// The cell behind a face of the boundary: the first that is around all its nodes.
  template <class Face>
  Index behind(const Face& face) const {
    for (const Index cell : of_node[std::size_t(face[0])])
      if (std::all_of(face.begin(), face.end(), [&](Index node) {
            const auto& around = of_node[std::size_t(node)];
            return std::binary_search(around.begin(), around.end(), cell);
          }))
        return cell;
    return 0;
  }
};

void addBoundary(Body& body, const Mesh& mesh) {
  const CellsAround cells(mesh);
  for (const Triangle& face : mesh.boundaryTriangles()) addTriangle(body, face[0], face[1], face[2], cells.behind(face));
  for (const Quad& face : mesh.boundaryQuads()) addQuad(body, face, cells.behind(face));
  for (const QuadraticTriangle& face : mesh.boundaryQuadraticTriangles()) addQuadratic(body, face, cells.behind(face));
  addEdges(body.edges, mesh.boundaryTriangles());
  addEdges(body.edges, mesh.boundaryQuads());
  addEdges(body.edges, mesh.boundaryQuadraticTriangles());
}

void addFaces(Body& body, const Mesh& mesh) {
  Index number = 0;
  for (const Triangle& face : mesh.triangles) addTriangle(body, face[0], face[1], face[2], number++);
  for (const Quad& face : mesh.quads) addQuad(body, face, number++);
  addEdges(body.edges, mesh.triangles);
  addEdges(body.edges, mesh.quads);
  for (const QuadraticTriangle& face : mesh.quadratic_triangles) addQuadratic(body, face, number++);
  addEdges(body.edges, mesh.quadratic_triangles);
}

std::size_t facesOf(const Mesh& mesh) {
  return mesh.triangles.size() + mesh.quads.size() + mesh.quadratic_triangles.size();
}
std::size_t volumesOf(const Mesh& mesh) {
  std::size_t sum = 0;
  forEachCellList([&sum](const CellKind& kind, const auto& cells) { sum += kind.dimension == 3 ? cells.size() : 0; }, mesh);
  return sum;
}
bool hasVolume(const Mesh& mesh) { return highestDimension(mesh) == 3; }
bool hasFaces(const Mesh& mesh) { return facesOf(mesh) > 0; }

/// The mesh that a force field is computed on: the one that it links, else the one that it finds as other components do.
const Topology* topologyOfField(const ForceField& field, const State& state) {
  if (const Data* data = field.data().find("topology"); data && data->link() && data->link()->target())
    return dynamic_cast<const Topology*>(data->link()->target());
  return findTopology(field, state, Link<Topology>("topology"));
}

/// Of the meshes of a state the one that the values of its fields belong to, else the one that components find.
const Mesh* meshOf(const State& state, const System* system) {
  const std::vector<ForceField*> none;
  for (const ForceField* field : system ? system->forceFields() : none) {
    if (&field->state() != &state || field->cellFields().empty()) continue;
    const Topology* topology = topologyOfField(*field, state);
    if (topology && (hasVolume(topology->mesh()) || hasFaces(topology->mesh()))) return &topology->mesh();
  }
  const std::vector<const Topology*> candidates = topologiesOf(state);
  if (candidates.empty()) return nullptr;
  const Topology* usual = topologyOf(state);
  for (const auto has : {hasVolume, hasFaces})
    if (!usual || !has(usual->mesh()))
      for (const Topology* candidate : candidates)
        if (has(candidate->mesh())) return &candidate->mesh();
  return usual ? &usual->mesh() : &candidates.front()->mesh();
}

/// Numbers of the state become page numbers.
void renumber(Body& body) {
  const Index size = body.state->size();
  std::vector<bool> drawn(std::size_t(size), false);
  const auto mark = [&drawn](const auto& groups) {
    for (const auto& group : groups)
      for (const Index node : group) drawn[std::size_t(node)] = true;
  };
  mark(body.triangles);
  mark(body.edges);
  mark(body.springs);
  for (const Beam& beam : body.beams)
    for (const Index node : beam.nodes) drawn[std::size_t(node)] = true;
  for (const Ball& ball : body.balls) drawn[std::size_t(ball.node)] = true;
  const bool has_cells = body.mesh && hasVolume(*body.mesh);
  std::vector<bool> in_cells(std::size_t(size), false);
  const auto markCells = [&in_cells](const CellKind& kind, const auto& cells) {
    for (std::size_t c = 0; kind.dimension == 3 && c < cells.size(); ++c)
      for (const Index node : cells[c]) in_cells[std::size_t(node)] = true;
  };
  if (has_cells) forEachCellList(markCells, *body.mesh);
  body.page.assign(std::size_t(size), -1);
  const auto take = [&](Index row) {
    body.page[std::size_t(row)] = Index(body.node.size());
    body.node.push_back(row);
  };
  for (Index row = 0; row < size; ++row) {
    if (body.state->kindOf(row) != RowKind::place || in_cells[std::size_t(row)] > drawn[std::size_t(row)]) continue;
    take(row);
    if (!drawn[std::size_t(row)]) body.points.push_back(body.page[std::size_t(row)]);
  }
  body.surface = Index(body.node.size());
  for (Index row = 0; row < size; ++row)
    if (body.state->kindOf(row) == RowKind::place && body.page[std::size_t(row)] < 0) take(row);
  for (Index row = 0; row + 1 < size; ++row)
    if (body.state->kindOf(row) == RowKind::place && body.state->kindOf(row + 1) == RowKind::turn)
      body.frames.push_back({body.page[std::size_t(row)], row + 1});
  const auto rename = [&body](auto& groups) {
    for (auto& group : groups)
      for (Index& node : group) node = body.page[std::size_t(node)];
  };
  rename(body.triangles);
  rename(body.edges);
  rename(body.springs);
  for (Ball& ball : body.balls) ball.node = body.page[std::size_t(ball.node)];
  for (Beam& beam : body.beams)
    for (std::size_t end : {0, 1}) {
      const auto frame = std::lower_bound(body.frames.begin(), body.frames.end(), beam.nodes[end] + 1,
                                          [](const auto& other, Index row) { return other[1] < row; });
      beam.frames[end] = Index(frame - body.frames.begin());
      beam.nodes[end] = body.page[std::size_t(beam.nodes[end])];
    }
}

/// Where a row of a system stands.
struct Place {
  Index body = -1, node = -1;  ///< the node's number in the state
};

Place placeOf(const std::vector<Body>& bodies, const System& system, Index row) {
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const State& state = *bodies[b].state;
    if (bodies[b].system == &system && row >= state.firstRow() && row < state.firstRow() + state.size())
      return {Index(b), row - state.firstRow()};
  }
  return {};
}

/// The body of a state; -1 when it is not drawn.
Index bodyOf(const std::vector<Body>& bodies, const State* state) {
  const auto found = std::find_if(bodies.begin(), bodies.end(), [&](const Body& body) { return body.state == state; });
  return found == bodies.end() ? -1 : Index(found - bodies.begin());
}

/// Springs within a body go to it, others to `between`.
void addSprings(const Simulation& simulation, std::vector<Body>& bodies, std::vector<std::array<Place, 2>>& between) {
  for (const DrawnSegments::Segment& segment : segmentsOf(simulation)) {
    const Place a{bodyOf(bodies, segment.first), segment.first_node};
    const Place b{bodyOf(bodies, segment.second), segment.second_node};
    if (a.body < 0 || b.body < 0) continue;
    if (a.body == b.body && segment.radius > 0)
      addBeam(bodies[std::size_t(a.body)], a.node, b.node, segment.radius);
    else if (a.body == b.body)
      bodies[std::size_t(a.body)].springs.push_back({a.node, b.node});
    else
      between.push_back({a, b});
  }
}

void addTies(const System& system, std::vector<std::array<Place, 2>>& ties, const std::vector<Body>& bodies) {
  std::vector<Tie> pairs;
  for (const ProjectiveConstraint* constraint : system.constraints().all()) constraint->addTies(pairs);
  for (const Tie& tie : pairs) ties.push_back({placeOf(bodies, system, tie.a), placeOf(bodies, system, tie.b)});
}

void addLinks(Drawing& drawing, const std::vector<std::array<Place, 2>>& pairs, bool are_ties) {
  for (const auto& [a, b] : pairs)
    if (a.body >= 0 && b.body >= 0)
      drawing.links.push_back({a.body, drawing.bodies[std::size_t(a.body)].page[std::size_t(a.node)], b.body,
                               drawing.bodies[std::size_t(b.body)].page[std::size_t(b.node)], are_ties});
}

void addFields(Drawing& drawing) {
  const auto add = [&drawing](std::size_t body, std::string name, const ForceField* source) {
    drawing.fields.push_back({int(drawing.fields.size()) + 1, Index(body), std::move(name), source, nullptr});
  };
  for (std::size_t b = 0; b < drawing.bodies.size(); ++b) {
    if (!drawing.bodies[b].system) continue;  // it has no force fields, and its velocity is zero
    add(b, "velocity", nullptr);
    if (drawing.bodies[b].cells() == 0) continue;
    for (const ForceField* field : drawing.bodies[b].system->forceFields())
      if (&field->state() == drawing.bodies[b].state)
        for (const std::string& name : field->cellFields()) add(b, name, field);
  }
}

}  // namespace

Index Body::cells() const {
  if (!mesh) return 0;
  const std::size_t volume = volumesOf(*mesh);
  return Index(volume > 0 ? volume : facesOf(*mesh));
}

std::vector<DrawnSegments::Segment> segmentsOf(const Simulation& simulation) {
  std::vector<DrawnSegments::Segment> segments;
  for (const auto& system : simulation.systems())
    for (const ForceField* field : system->forceFields())
      if (const auto* drawn = dynamic_cast<const DrawnSegments*>(field)) drawn->addSegments(segments);
  return segments;
}

namespace {

void addBody(Drawing& drawing, const State& state, const System* system) {
  if (state.size() == 0 || state.kindOf(0) == RowKind::value) return;  // numbers are nowhere
  Body body;
  body.state = &state;
  body.system = system;
  body.mesh = meshOf(state, system);
  if (body.mesh && hasVolume(*body.mesh)) {
    addBoundary(body, *body.mesh);
  } else if (body.mesh && hasFaces(*body.mesh)) {
    addFaces(body, *body.mesh);
  } else if (body.mesh) {
    body.edges.insert(body.edges.end(), body.mesh->edges.begin(), body.mesh->edges.end());
  }
  makeUnique(body.edges);
  if (state.rows_per_node != 1) {  // lines between the centres of frames
    body.mesh = nullptr;
    body.triangles.clear(), body.owner.clear();
    for (Edge& edge : body.edges)
      for (Index& node : edge) node *= state.rows_per_node;
  }
  drawing.bodies.push_back(std::move(body));
}

std::shared_ptr<const Vector> standingRows(const State& state) {
  auto rows = std::make_shared<Vector>(2 * state.size());
  for (Index row = 0; row < state.size(); ++row)
    placeRow(state.kindOf(row), state.position[std::size_t(row)], rows->rows(), row);
  return rows;
}

/// Bodies that others touch though nothing moves them, and the balls of those that are points.
void addSolids(Drawing& drawing, const Simulation& simulation) {
  std::vector<DrawnSolids*> solids;
  simulation.root().collect(solids);
  std::vector<const State*> states;
  std::vector<DrawnSolids::Sphere> spheres;
  for (const DrawnSolids* solid : solids) solid->addSolids(states, spheres);
  for (const State* state : states)
    if (!state->isBound() && bodyOf(drawing.bodies, state) < 0) {
      const std::size_t before = drawing.bodies.size();
      addBody(drawing, *state, nullptr);
      if (drawing.bodies.size() > before) drawing.bodies.back().standing = standingRows(*state);
    }
  for (const DrawnSolids::Sphere& sphere : spheres) {
    const Index body = bodyOf(drawing.bodies, sphere.state);
    if (body < 0 || !(sphere.radius > 0)) continue;
    Body& of = drawing.bodies[std::size_t(body)];
    if (of.triangles.empty() && of.edges.empty()) of.balls.push_back({sphere.node * of.state->rows_per_node, sphere.radius});
  }
}

}  // namespace

Drawing drawingOf(const Simulation& simulation) {
  Drawing drawing;
  for (const auto& system : simulation.systems())
    for (const State* state : system->states()) addBody(drawing, *state, system.get());
  addSolids(drawing, simulation);
  std::vector<std::array<Place, 2>> ties, springs;
  for (const auto& system : simulation.systems()) addTies(*system, ties, drawing.bodies);
  addSprings(simulation, drawing.bodies, springs);
  for (Body& body : drawing.bodies) {
    dropEdgesOfBeams(body);
    renumber(body);
  }
  chooseSizes(drawing.bodies);
  addLinks(drawing, springs, false);
  addLinks(drawing, ties, true);
  std::erase_if(drawing.links, [](const BodyLink& link) { return link.node_a < 0 || link.node_b < 0; });
  addFields(drawing), addNodeFields(simulation, drawing);
  addContacts(simulation, drawing);
  return drawing;
}

namespace {

/// A number; of principal values the largest, which comes first; the norm of a vector, of a symmetric tensor xx yy zz xy yz zx,
/// whose shears stand for two components each, and of a tensor of nine numbers. No turn of the axes changes it.
double colourOf(const std::string& name, const double* values, std::size_t width) {
  if (width == 1 || name.starts_with("principal")) return *values;
  double square = 0;
  for (std::size_t k = 0; k < width; ++k) square += (width == 6 && k >= 3 ? 2 : 1) * values[k] * values[k];
  return std::sqrt(square);
}

}  // namespace

bool cellValues(const Field& field, const Body& body, std::vector<double>& work, std::vector<float>& out) {
  const auto [kind, width] = field.source->cellFieldShape(field.name);
  field.source->cellField(field.name, body.system->x, work);
  const int dimension = hasVolume(*body.mesh) ? 3 : 2;
  std::size_t all = 0, first = 0, count = 0;
  const auto look = [&, of_field = kind](const CellKind& of, const auto& cells) {
    if (of.dimension != dimension) return;
    if (of_field && of.type == of_field->type) {
      first = all;
      count = cells.size();
    }
    all += cells.size();
  };
  forEachCellList(look, *body.mesh);
  if (count == 0 || work.size() != width * count) return false;
  out.assign(all, std::numeric_limits<float>::quiet_NaN());
  for (std::size_t i = 0; i < count; ++i) out[first + i] = float(colourOf(field.name, work.data() + width * i, width));
  return true;
}

std::string unitOfField(const std::string& name) {
  static const std::map<std::string, std::string> units{
      {"vonMises", "Pa"}, {"stress", "Pa"},         {"principalStress", "Pa"}, {"pressure", "Pa"}, {"J", "-"},
      {"strain", "-"},    {"principalStrain", "-"}, {"velocity", "m/s"},       {"displacement", "m"},
      {"elasticVonMises", "Pa"}, {"elasticStress", "Pa"}, {"plasticStrain", "-"}};
  const auto found = units.find(name);
  return found == units.end() ? std::string() : found->second;
}

std::string unitOf(const Field& field) {
  if (!field.data) return unitOfField(field.name);
  return field.data->unitText().empty() ? "-" : field.data->unitText();
}

}  // namespace stroma::drawing
