// SPDX-License-Identifier: LGPL-2.1-or-later
// The module's door: a live view, or a page of a whole run.
#include <fmt/format.h>

#include <algorithm>

#include "framework/scene/abi.h"
#include "framework/scene/output_file.h"
#include "framework/scene/services.h"
#include "tools/view/scene_packets.h"
#include "tools/view/server.h"
#include "tools/view/standalone_page.h"

namespace stroma::view {
namespace {

/// Numbers of the fields of cells with these names.
std::set<int> fieldsCalled(const std::vector<std::string>& names, const Drawing& drawing) {
  std::set<int> numbers;
  for (const std::string& name : names) {
    std::vector<std::string> known;
    bool found = false;
    for (const Field& field : drawing.fields) {
      known.push_back(field.name);
      if (field.name == name) numbers.insert(field.id), found = true;
    }
    if (!found)
      throw ComponentError(fmt::format("no body has a field '{}'", name), fmt::format("{}", fmt::join(known, ", ")),
                           nearest(name, known));
  }
  return numbers;
}

class BrowserViewer final : public Viewer {
 public:
  int view(Session& session, const ViewRequest& request) const override {
    Server server(request);
    LiveRun run(session, request, server);
    return server.serve(run);
  }

  void writePage(Session& session, const ExportRequest& request) const override {
    Simulation& simulation = session.simulation();
    const Drawing drawing = drawingOf(simulation);
    FrameMaker maker(simulation, drawing);
    Demand demand;
    demand.all_nodes = request.inside;
    demand.fields = fieldsCalled(request.fields, drawing);
    checkAccess(request.file, true);
    Packet scene = scenePacket(simulation, drawing, 1, "recording");
    if (!request.fields.empty())
      scene.header()["view"] = {{"colour", request.fields.front() + "|cells|" + unitOfField(request.fields.front())},
                                {"range", "most"}};
    std::vector<std::string> packets{scene.bytes(), heldPacket(simulation, drawing, 1, simulation.time()).bytes()};
    if (request.inside) packets.push_back(cellsPacket(drawing, 1).bytes());
    long frame = 0;
    const auto keep = [&] {
      auto packet = maker.make(demand, ++frame, simulation.time(), true);
      packet->header()["generation"] = 1;
      packets.push_back(withShortPositions(*packet).bytes());
    };
    keep();
    RunLimits limits;
    limits.steps = request.steps;
    limits.after_step = [&](const StepReport&, double) {
      if (simulation.steps() % request.every == 0) keep();
    };
    const RunReport report = session.run(limits);
    if (report.end != RunEnd::done && report.end != RunEnd::stopped)
      throw std::runtime_error("the run has no result to show: " + report.reason);
    const std::string page = standalonePage(packets);
    if (page.size() > most_page_bytes)
      throw std::runtime_error(fmt::format(
          "{} would have {} MB, more than the {} MB that browsers open well (expected --every {})", request.file,
          page.size() >> 20, most_page_bytes >> 20, request.every * long(page.size() / most_page_bytes + 1)));
    writeWholeFile(request.file, page);
  }
};

}  // namespace
}  // namespace stroma::view

extern "C" __attribute__((visibility("default"))) const stroma::ServiceInfo* stroma_service() {
  static const stroma::ServiceInfo info{STROMA_ABI, stroma::view::Viewer::role, []() -> void* {
                                          return static_cast<stroma::view::Viewer*>(new stroma::view::BrowserViewer);
                                        }};
  return &info;
}
