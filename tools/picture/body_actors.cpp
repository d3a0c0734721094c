// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/picture/body_actors.h"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkClipPolyData.h>
#include <vtkCutter.h>
#include <vtkFloatArray.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkTrivialProducer.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "framework/mesh/cell_lists.h"

namespace stroma::picture {
namespace {

constexpr double crease = 1.15,
                 ghost_crease = 1.4;  // [rad]: coarse meshes of smooth organs have edges of up to 60 degrees
constexpr Colour spring_colour{0.45, 0.4, 0.7}, line_colour{0.5, 0.52, 0.54}, ghost_colour{0.55, 0.57, 0.6},
    held_colour{0.2, 0.21, 0.23}, guided_colour{0.93, 0.66, 0.1};

vtkSmartPointer<vtkFloatArray> arrayOf(const float* values, std::size_t count, int components, const char* name) {
  auto array = vtkSmartPointer<vtkFloatArray>::New();
  array->SetName(name);
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(vtkIdType(count));
  std::copy_n(values, count * std::size_t(components), array->GetPointer(0));
  return array;
}

template <class Groups>
vtkSmartPointer<vtkCellArray> cellsOf(const Groups& groups) {
  auto cells = vtkSmartPointer<vtkCellArray>::New();
  for (const auto& group : groups) {
    cells->InsertNextCell(int(group.size()));
    for (const Index node : group) cells->InsertCellPoint(node);
  }
  return cells;
}

vtkSmartPointer<vtkCellArray> pointsOf(const std::vector<Index>& nodes) {
  auto cells = vtkSmartPointer<vtkCellArray>::New();
  for (const Index node : nodes) {
    cells->InsertNextCell(1);
    cells->InsertCellPoint(node);
  }
  return cells;
}

void setColour(vtkActor& actor, const Colour& colour) {
  actor.GetProperty()->SetColor(colour[0], colour[1], colour[2]);
}

/// The colour as it is.
void leaveUnlit(vtkActor& actor) {
  actor.GetProperty()->SetLighting(false);
  actor.GetProperty()->SetAmbient(0);
  actor.GetProperty()->SetDiffuse(1);
}


}  // namespace

BodyActors::BodyActors(const drawing::Body& body, ValuesAt values_at, Points rest, const Colour& colour,
                       const Style& style, vtkRenderer& renderer)
    : body_(body),
      values_at_(values_at),
      rest_(std::move(rest)),
      colour_(colour),
      style_(style),
      renderer_(renderer),
      smooth_(body.triangles, rest_, crease),
      side_(meanSide(body.triangles, rest_)) {
  if (!body.triangles.empty()) buildSurface();
  if (style.plane && body.mesh && highestDimension(*body.mesh) == 3) buildSection();
  buildLines();
  const PictureRequest& request = *style.request;
  if (request.ghost) {
    vtkNew<vtkPoints> points;
    points->SetData(arrayOf(rest_.data(), rest_.size() / 3, 3, "rest"));
    ghost_->SetPoints(points);
    vtkNew<vtkTrivialProducer> whole;  // a cut shows the inside of the body, in the outline of all of it
    whole->SetOutput(ghost_);
    const auto actor = addActor(*whole, false);
    setColour(*actor, ghost_colour);
    leaveUnlit(*actor);
    actor->GetProperty()->SetLineWidth(float(1.5 * style.pixel));
  }
  points_actor_ = addNodes(points_, body.points, colour);
  if (request.bare) return;
  held_actor_ = addNodes(held_, {}, held_colour);
  guided_actor_ = addNodes(guided_, {}, guided_colour);
  for (vtkActor* actor : {held_actor_.Get(), guided_actor_.Get()}) actor->GetMapper()->ScalarVisibilityOff();
  frames_->SetPoints(vtkNew<vtkPoints>());
  const auto actor = addActor(*clipped(frames_), false);
  actor->GetMapper()->ScalarVisibilityOn();
  leaveUnlit(*actor);
  actor->GetProperty()->SetLineWidth(float(2.5 * style.pixel));
}

/// Behind the plane of the cut, if there is one.
vtkSmartPointer<vtkAlgorithm> BodyActors::clipped(vtkPolyData* data) {
  if (!style_.plane) {
    const auto whole = vtkSmartPointer<vtkTrivialProducer>::New();
    whole->SetOutput(data);
    return whole;
  }
  const auto clip = vtkSmartPointer<vtkClipPolyData>::New();
  clip->SetInputData(data);
  clip->SetClipFunction(style_.plane);
  clip->InsideOutOn();
  return clip;
}

vtkSmartPointer<vtkActor> BodyActors::addActor(vtkAlgorithm& from, bool coloured) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(from.GetOutputPort());
  mapper->SetScalarVisibility(coloured);
  if (coloured) {
    mapper->SetLookupTable(style_.colours);
    mapper->UseLookupTableScalarRangeOn();
    mapper->SetInterpolateScalarsBeforeMapping(values_at_ == ValuesAt::nodes);
    if (values_at_ == ValuesAt::nodes)
      mapper->SetScalarModeToUsePointData();
    else
      mapper->SetScalarModeToUseCellData();
  }
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  setColour(*actor, colour_);
  vtkProperty& property = *actor->GetProperty();
  property.SetInterpolationToPhong();
  // colours that mean something stay near those of the legend
  property.SetAmbient(coloured ? 0.70 : 0.42);
  property.SetDiffuse(coloured ? 0.33 : 0.64);
  property.SetSpecular(coloured ? 0.02 : 0.06);
  property.SetSpecularPower(24);
  if (!style_.request->shaded) leaveUnlit(*actor);
  renderer_.AddActor(actor);
  return actor;
}

vtkSmartPointer<vtkActor> BodyActors::addNodes(vtkPolyData* data, const std::vector<Index>& nodes,
                                               const Colour& colour) {
  data->SetPoints(nodes_);
  data->SetVerts(pointsOf(nodes));
  const auto actor = addActor(*clipped(data), values_at_ == ValuesAt::nodes);
  setColour(*actor, colour);
  actor->GetProperty()->SetRenderPointsAsSpheres(true);
  return actor;
}

void BodyActors::buildSurface() {
  surface_->SetPoints(vtkNew<vtkPoints>());
  surface_->SetPolys(cellsOf(smooth_.triangles()));
  addActor(*clipped(surface_), values_at_ != ValuesAt::none);
}

/// The inside of the body where the plane cuts it.
void BodyActors::buildSection() {
  grid_->SetPoints(nodes_);
  const auto add = [&](const CellKind& kind, const auto& cells) {
    for (std::size_t c = 0; kind.dimension == 3 && c < cells.size(); ++c) {
      std::array<vtkIdType, most_cell_nodes> pages;
      for (std::size_t k = 0; k < cells[c].size(); ++k) pages[k] = body_.page[std::size_t(cells[c][kind.vtk.order[k]])];
      grid_->InsertNextCell(kind.vtk.number, vtkIdType(cells[c].size()), pages.data());
    }
  };
  grid_->Allocate(body_.cells());
  forEachCellList(add, *body_.mesh);
  vtkNew<vtkCutter> cutter;
  cutter->SetInputData(grid_);
  cutter->SetCutFunction(style_.plane);
  const bool outlines = style_.request->edges;
  cutter->SetGenerateTriangles(!outlines);
  const auto actor = addActor(*cutter, values_at_ != ValuesAt::none);
  actor->GetProperty()->SetInterpolationToFlat();
  if (!outlines) return;
  actor->GetProperty()->EdgeVisibilityOn();
  actor->GetProperty()->SetEdgeColor(line_colour[0], line_colour[1], line_colour[2]);
  actor->GetProperty()->SetLineWidth(float(0.7 * style_.pixel));
}

void BodyActors::buildLines() {
  const bool bare = body_.triangles.empty();  // lines alone are what there is to see
  edges_->SetPoints(nodes_), springs_->SetPoints(nodes_);
  edges_->SetLines(cellsOf(body_.edges)), springs_->SetLines(cellsOf(body_.springs));
  if (!body_.edges.empty() && (bare || style_.request->edges)) {
    const auto actor = addActor(*clipped(edges_), bare && values_at_ == ValuesAt::nodes);
    if (!bare) setColour(*actor, line_colour);
    if (!bare) leaveUnlit(*actor);
    actor->GetProperty()->SetRenderLinesAsTubes(bare);
    actor->GetProperty()->SetLineWidth(float((bare ? 5 : 0.8) * style_.pixel));
  }
  if (!body_.beams.empty()) {
    addActor(*clipped(beams_), values_at_ == ValuesAt::nodes);
    const auto actor = addActor(*clipped(beam_lines_), values_at_ == ValuesAt::nodes);
    actor->GetProperty()->SetRenderLinesAsTubes(true);
    actor->GetProperty()->SetLineWidth(float(3 * style_.pixel));
  }
  if (!body_.balls.empty()) addActor(*clipped(balls_), values_at_ == ValuesAt::nodes);
  if (body_.springs.empty()) return;
  const auto actor = addActor(*clipped(springs_), false);
  setColour(*actor, spring_colour);
  actor->GetProperty()->SetRenderLinesAsTubes(true);
  actor->GetProperty()->SetLineWidth(float(2.5 * style_.pixel));
}

void BodyActors::setScalars(vtkDataSet& data, const std::vector<float>& values, bool of_cells) const {
  const auto array = arrayOf(values.data(), values.size(), 1, "values");
  if (of_cells)
    data.GetCellData()->SetScalars(array);
  else
    data.GetPointData()->SetScalars(array);
}

void BodyActors::show(const BodyShot& shot) {
  drawn_ = drawnIn(shot);
  nodes_->SetData(arrayOf(drawn_.data(), drawn_.size() / 3, 3, "places"));
  nodes_->Modified();
  if (!body_.triangles.empty()) {
    const std::vector<Index>& nodes = smooth_.nodes();
    Points corners(3 * nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i)
      std::copy_n(drawn_.data() + 3 * std::size_t(nodes[i]), 3, corners.data() + 3 * i);
    surface_->GetPoints()->SetData(arrayOf(corners.data(), nodes.size(), 3, "places"));
    surface_->GetPoints()->Modified();
    surface_->GetPointData()->SetNormals(arrayOf(smooth_.normals(drawn_).data(), nodes.size(), 3, "normals"));
  }
  if (!shot.values.empty()) {
    std::vector<float> of_surface;
    if (values_at_ == ValuesAt::nodes)
      for (const Index node : smooth_.nodes()) of_surface.push_back(shot.values[std::size_t(node)]);
    else
      for (const Index cell : body_.owner) of_surface.push_back(shot.values[std::size_t(cell)]);
    setScalars(*surface_, of_surface, values_at_ == ValuesAt::cells);
    setScalars(*grid_, shot.values, values_at_ == ValuesAt::cells);
    if (values_at_ == ValuesAt::nodes)
      for (vtkPolyData* data : {edges_.Get(), points_.Get()}) setScalars(*data, shot.values, false);
  }
  for (vtkPolyData* data : {edges_.Get(), springs_.Get(), points_.Get()}) data->Modified();
  grid_->Modified();
  surface_->Modified();
  showBeams(shot), showBalls(shot);
  if (style_.request->bare) return;
  held_->SetVerts(pointsOf(shot.held));
  guided_->SetVerts(pointsOf(shot.guided));
  held_->Modified(), guided_->Modified();
  showFrames(shot);
}

/// Where the nodes are drawn.
Points BodyActors::drawnIn(const BodyShot& shot) const {
  Points drawn = rest_;
  for (std::size_t i = 0; i < drawn.size(); ++i)
    drawn[i] += float(style_.request->exaggeration) * (shot.x[i] - rest_[i]);
  return drawn;
}

void BodyActors::forEachPlace(const BodyShot& shot, const std::function<void(const Vec3&, double)>& visit) const {
  const Points drawn = drawnIn(shot);
  for (std::size_t i = 0; i < drawn.size(); i += 3) visit(Vec3(drawn[i], drawn[i + 1], drawn[i + 2]), 0);
  for (const drawing::Beam& beam : body_.beams)
    for (const Vec3& place : curveOf(beam, drawn, shot)) visit(place, beam.radius);
  for (const drawing::Ball& ball : body_.balls) {
    const float* p = drawn.data() + 3 * std::size_t(ball.node);
    visit(Vec3(p[0], p[1], p[2]), ball.radius);
  }
  if (style_.request->bare) return;
  for (std::size_t f = 0; f < body_.frames.size(); ++f) {
    const std::size_t page = 3 * std::size_t(body_.frames[f][0]);
    const Mat3 turn = turnOf(shot, f).toRotationMatrix();
    for (int axis = 0; axis < 3; ++axis)
      visit(Vec3(drawn[page], drawn[page + 1], drawn[page + 2]) + body_.axis * turn.col(axis), 0);
  }
}

void BodyActors::face(const Vec3& back, double pixels_per_metre) {
  if (style_.request->ghost) {
    ghost_->SetLines(
        cellsOf(body_.triangles.empty() ? body_.edges : outline(body_.triangles, rest_, back, ghost_crease)));
    ghost_->Modified();
  }
  // dots of fine meshes do not melt into one
  const double spacing = side_ > 0 ? side_ * pixels_per_metre : 1e9;
  const auto size = [&](double most) {
    return float(std::clamp(0.34 * spacing, 2 * style_.pixel, most * style_.pixel));
  };
  points_actor_->GetProperty()->SetPointSize(float(9 * style_.pixel));
  if (held_actor_) held_actor_->GetProperty()->SetPointSize(size(7));
  if (guided_actor_) guided_actor_->GetProperty()->SetPointSize(size(8));
}

Vec3 BodyActors::drawnAt(Index page) const {
  const float* p = drawn_.data() + 3 * std::size_t(page);
  return {p[0], p[1], p[2]};
}

}  // namespace stroma::picture
