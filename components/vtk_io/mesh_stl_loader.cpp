// SPDX-License-Identifier: LGPL-2.1-or-later
// Reads the triangles of an STL file, ASCII or binary.
//
// An STL file has no shared nodes: the corners that agree in all digits become one node, numbered in the order in which
// they first appear. Triangles with two equal corners have no area; they are left out and counted in a note.
//
// Source: VTK's reader (vtkSTLReader); the attributes are SOFA's.
//
// Example:
// <Node name="root">
//   <MeshSTLLoader name="loader" filename="meshes/block.stl"/>
//   <TriangleSetTopologyContainer name="skin" src="@loader"/>
// </Node>
#include <fmt/format.h>
#include <vtkIdList.h>
#include <vtkLogger.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkPolyData.h>
#include <vtkSTLReader.h>
#include <vtkSmartPointer.h>

#include <map>

#include "framework/mesh/mesh_loader.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// Keeps what VTK would print.
class CapturedOutput : public vtkOutputWindow {
 public:
  static CapturedOutput* New();
  vtkTypeMacro(CapturedOutput, vtkOutputWindow);
  void DisplayText(const char* text) override { text_ += text; }
  std::string text_;
};
vtkStandardNewMacro(CapturedOutput);

class MeshSTLLoader : public MeshLoader {
 public:
  void declare(DataTable& table) override {
    MeshLoader::declare(table);
    for (const char* name : {"headerSize", "forceBinary", "mergePositionUsingMap"}) table.addVisualOnly(name);
  }

 protected:
  void read(const std::string& file, Mesh& mesh) override {
    const std::string name = file.substr(file.rfind('/') + 1);
    const vtkSmartPointer<vtkOutputWindow> before = vtkOutputWindow::GetInstance();
    const auto window = vtkSmartPointer<CapturedOutput>::New();
    vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);  // a second way to the terminal
    vtkOutputWindow::SetInstance(window);
    const auto reader = vtkSmartPointer<vtkSTLReader>::New();
    reader->SetFileName(file.c_str());
    reader->MergingOff();
    reader->Update();
    vtkOutputWindow::SetInstance(before);
    if (window->text_.find("ERROR") != std::string::npos)
      throw ComponentError(fmt::format("{} cannot be read as STL", name), "an ASCII or binary STL file");
    merge(*reader->GetOutput(), mesh);
  }

 private:
  void merge(vtkPolyData& data, Mesh& mesh) {
    std::map<std::array<double, 3>, Index> node_at;
    const auto ids = vtkSmartPointer<vtkIdList>::New();
    long without_area = 0;
    for (vtkIdType c = 0; c < data.GetNumberOfCells(); ++c) {
      data.GetCellPoints(c, ids);
      if (ids->GetNumberOfIds() != 3) continue;
      Triangle triangle;
      for (vtkIdType k = 0; k < 3; ++k) {
        std::array<double, 3> p;
        data.GetPoint(ids->GetId(k), p.data());
        const auto [it, is_new] = node_at.try_emplace(p, mesh.nodes());
        if (is_new) mesh.position.push_back(Vec3(p[0], p[1], p[2]));
        triangle[std::size_t(k)] = it->second;
      }
      if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0])
        ++without_area;
      else
        mesh.triangles.push_back(triangle);
    }
    if (without_area > 0) inform(fmt::format("{} triangles with equal corners were left out", without_area));
  }
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(mesh_stl_loader) {
  factory.add<stroma::MeshSTLLoader>("MeshSTLLoader", "reads the surface of an STL file");
}
