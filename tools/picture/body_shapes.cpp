// SPDX-License-Identifier: LGPL-2.1-or-later
// Of a body: the axes of its frames, its round beams and its balls.
#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkCellData.h>
#include <vtkFloatArray.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkSphereSource.h>
#include <vtkUnsignedCharArray.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "tools/picture/body_actors.h"

namespace stroma::picture {
namespace {

constexpr std::array<std::array<unsigned char, 3>, 3> body_axis_colours{{{204, 64, 56}, {64, 153, 72}, {56, 102, 217}}};
constexpr int beam_pieces = 12, beam_sides = 16;
constexpr std::size_t many_balls = 300;  // then each has fewer faces

}  // namespace

Quaternion BodyActors::turnOf(const BodyShot& shot, std::size_t frame) {
  const float* q = shot.turns.data() + 4 * frame;
  return Quaternion(q[3], q[0], q[1], q[2]).normalized();
}

void BodyActors::showFrames(const BodyShot& shot) {
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> axes;
  vtkNew<vtkUnsignedCharArray> colours;
  colours->SetNumberOfComponents(3);
  for (std::size_t f = 0; f < body_.frames.size(); ++f) {
    const Vec3 centre = drawnAt(body_.frames[f][0]);
    const Mat3 turn = turnOf(shot, f).toRotationMatrix();
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 end = centre + body_.axis * turn.col(axis);
      const vtkIdType ends[2] = {points->InsertNextPoint(centre.data()), points->InsertNextPoint(end.data())};
      axes->InsertNextCell(2, ends);
      colours->InsertNextTypedTuple(body_axis_colours[std::size_t(axis)].data());
    }
  }
  frames_->SetPoints(points);
  frames_->SetLines(axes);
  frames_->GetCellData()->SetScalars(colours);
  frames_->Modified();
}

std::vector<Vec3> BodyActors::curveOf(const drawing::Beam& beam, const Points& drawn, const BodyShot& shot) const {
  const auto place = [&](Index page) { return Vec3(drawn[3 * page], drawn[3 * page + 1], drawn[3 * page + 2]); };
  return drawing::beamCurve(beam, place(beam.nodes[0]), place(beam.nodes[1]), turnOf(shot, std::size_t(beam.frames[0])),
                            turnOf(shot, std::size_t(beam.frames[1])), beam_pieces);
}

/// A tube around the curve of each beam, and the curve itself, which is seen where the tube is thinner than a line.
void BodyActors::showBeams(const BodyShot& shot) {
  if (body_.beams.empty()) return;
  vtkNew<vtkPoints> points, middles;
  vtkNew<vtkCellArray> quads, lines;
  vtkNew<vtkFloatArray> normals, values, middle_values;
  normals->SetNumberOfComponents(3);
  for (const drawing::Beam& beam : body_.beams) {
    const std::vector<Vec3> curve = curveOf(beam, drawn_, shot);
    Vec3 side = Vec3::Zero();  // carried along without a twist
    const vtkIdType first = points->GetNumberOfPoints();
    lines->InsertNextCell(int(curve.size()));
    for (std::size_t i = 0; i < curve.size(); ++i) {
      const Vec3 tangent = (curve[std::min(i + 1, curve.size() - 1)] - curve[i > 0 ? i - 1 : 0]).normalized();
      if (i == 0) side = tangent.unitOrthogonal();
      side = (side - side.dot(tangent) * tangent).normalized();
      const Vec3 other = tangent.cross(side);
      const double s = double(i) / beam_pieces;
      const auto of = [&](std::size_t end) { return double(shot.values[std::size_t(beam.nodes[end])]); };
      const float value = values_at_ == ValuesAt::nodes ? float((1 - s) * of(0) + s * of(1)) : 0;
      lines->InsertCellPoint(middles->InsertNextPoint(curve[i].data()));
      middle_values->InsertNextValue(value);
      for (int k = 0; k < beam_sides; ++k) {
        const double angle = 2 * std::numbers::pi * k / beam_sides;
        const Vec3 normal = std::cos(angle) * side + std::sin(angle) * other, at = curve[i] + beam.radius * normal;
        points->InsertNextPoint(at.data());
        normals->InsertNextTuple(normal.data());
        values->InsertNextValue(value);
        if (i + 1 == curve.size()) continue;
        const vtkIdType here = first + vtkIdType(i) * beam_sides, next = (k + 1) % beam_sides;
        const vtkIdType quad[4] = {here + k, here + next, here + beam_sides + next, here + beam_sides + k};
        quads->InsertNextCell(4, quad);
      }
    }
  }
  beams_->SetPoints(points), beams_->SetPolys(quads), beams_->GetPointData()->SetNormals(normals);
  beam_lines_->SetPoints(middles), beam_lines_->SetLines(lines);
  if (values_at_ == ValuesAt::nodes)
    beams_->GetPointData()->SetScalars(values), beam_lines_->GetPointData()->SetScalars(middle_values);
  beams_->Modified(), beam_lines_->Modified();
}

void BodyActors::showBalls(const BodyShot& shot) {
  if (body_.balls.empty()) return;
  vtkNew<vtkSphereSource> unit;
  const int sides = body_.balls.size() > many_balls ? 12 : 32;
  unit->SetRadius(1), unit->SetThetaResolution(sides), unit->SetPhiResolution(sides);
  unit->Update();
  vtkPolyData& shape = *unit->GetOutput();
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> faces;
  vtkNew<vtkFloatArray> normals, values;
  normals->SetNumberOfComponents(3);
  for (const drawing::Ball& ball : body_.balls) {
    const vtkIdType first = points->GetNumberOfPoints();
    const Vec3 centre = drawnAt(ball.node);
    for (vtkIdType i = 0; i < shape.GetNumberOfPoints(); ++i) {
      Vec3 normal;
      shape.GetPoint(i, normal.data());
      const Vec3 at = centre + ball.radius * normal;
      points->InsertNextPoint(at.data());
      normals->InsertNextTuple(normal.data());
      if (values_at_ == ValuesAt::nodes) values->InsertNextValue(shot.values[std::size_t(ball.node)]);
    }
    const auto shape_faces = vtk::TakeSmartPointer(shape.GetPolys()->NewIterator());
    for (shape_faces->GoToFirstCell(); !shape_faces->IsDoneWithTraversal(); shape_faces->GoToNextCell()) {
      vtkIdType count = 0;
      const vtkIdType* corners = nullptr;
      shape_faces->GetCurrentCell(count, corners);
      faces->InsertNextCell(int(count));
      for (vtkIdType k = 0; k < count; ++k) faces->InsertCellPoint(first + corners[k]);
    }
  }
  balls_->SetPoints(points), balls_->SetPolys(faces), balls_->GetPointData()->SetNormals(normals);
  if (values_at_ == ValuesAt::nodes) balls_->GetPointData()->SetScalars(values);
  balls_->Modified();
}

}  // namespace stroma::picture
