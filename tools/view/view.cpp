// SPDX-License-Identifier: LGPL-2.1-or-later
// The module's door: a live view, or a page of a whole run.
#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "framework/scene/abi.h"
#include "framework/scene/output_file.h"
#include "framework/scene/services.h"
#include "tools/drawing/recording.h"
#include "tools/units/unit_system.h"
#include "tools/view/page_numbers.h"
#include "tools/view/scene_packets.h"
#include "tools/view/server.h"
#include "tools/view/standalone_page.h"

namespace stroma::view {
namespace {

/// Numbers of the fields with these names.
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

/// Takes pictures of a simulation into a page.
class PageMaker {
 public:
  PageMaker(Simulation& simulation, const ExportRequest& request)
      : simulation_(simulation), request_(request), drawing_(drawingOf(simulation)), numbers_(drawing_), frames_(simulation, drawing_) {
    demand_.all_nodes = request.inside;
    addScene();
    opening_ = page_.size();
  }

  /// Meshes have changed: what comes is of others.
  void follow(const NodesNow& now) {
    drawing_ = drawingOf(simulation_);
    numbers_.follow(drawing_, now);
    frames_.forget();
  }
  void keep(double time) {
    if (numbers_.isUntold()) addScene();
    auto packet = frames_.make(demand_, ++pictures_, time, true);
    packet->header()["generation"] = generation_;
    page_.add(withShortPositions(*packet).bytes());
  }
  /// Throws std::runtime_error when there is too much already; `all`: how many pictures there would be.
  void checkSize(long all) const { checkSize(page_.size(), all); }
  void write() {
    const std::string page = page_.finish();
    checkSize(page.size(), pictures_);
    writeWholeFile(request_.file, page);
  }

 private:
  void addScene() {
    demand_.fields = fieldsCalled(request_.fields, drawing_);
    demand_.contacts = !drawing_.contacts.empty();
    Packet scene = scenePacket(simulation_, drawing_, ++generation_, "recording");
    for (const Field& field : drawing_.fields)  // of several with the name any will do
      if (!request_.fields.empty() && field.name == request_.fields.front() && generation_ == 1)
        scene.header()["view"] = {{"colour", field.name + (field.source ? "|cells|" : "|nodes|") +
                                                 unitsOf(simulation_.scene()).unit(drawing::unitOf(field))},
                                  {"range", "most"}};
    if (numbers_.isUntold()) {
      scene.header()["follows"] = numbers_.toldGeneration();
      for (std::size_t b = 0; b < drawing_.bodies.size(); ++b)
        scene.add(std::to_string(b) + ".before", numbers_.before(drawing_.bodies[b]));
    }
    numbers_.told(drawing_, generation_);
    page_.add(scene.bytes());
    page_.add(heldPacket(simulation_, drawing_, generation_, simulation_.time()).bytes());
    if (request_.inside) page_.add(cellsPacket(drawing_, generation_).bytes());
  }

  void checkSize(std::size_t size, long all) const {
    if (size <= most_page_bytes) return;
    constexpr double megabyte = 1 << 20, most = most_page_bytes, reserve = 1.1;  // pictures differ in size
    const double pictures = double(size - opening_) / double(pictures_) * double(all);
    const double room = most - double(opening_);
    if (room <= 0 || pictures_ < 2)
      throw std::runtime_error(
          fmt::format("{} would have more than the {:.0f} MB that browsers open well with the first picture alone "
                      "(expected a smaller mesh, or no --inside)",
                      request_.file, most / megabyte));
    throw std::runtime_error(fmt::format(
        "{} would have about {:.0f} MB, more than the {:.0f} MB that browsers open well (expected --every {})",
        request_.file, (double(opening_) + pictures) / megabyte, most / megabyte,
        request_.every * long(std::ceil(reserve * pictures / room))));
  }

  Simulation& simulation_;
  const ExportRequest& request_;
  Drawing drawing_;
  PageNumbers numbers_;
  int generation_ = 0;  ///< of the scene that the page has last
  FrameMaker frames_;
  Demand demand_;
  StandalonePage page_;
  std::size_t opening_ = 0;  ///< bytes of the page without pictures
  long pictures_ = 0;
};

class BrowserViewer final : public Viewer {
 public:
  int view(Session& session, const ViewRequest& request) const override {
    Server server(request);
    LiveRun run(session, request, server);
    if (request.listening) request.listening();
    return server.serve(run);
  }

  RunReport writePage(Session& session, const ExportRequest& request) const override {
    PageMaker page(session.simulation(), request);
    const RunReport report = request.recording.empty() ? keepRun(session, request, page)
                                                       : keepRecording(session, request, page);
    if (report.end == RunEnd::done) page.write();
    return report;
  }

 private:
  static RunReport keepRun(Session& session, const ExportRequest& request, PageMaker& page) {
    const Simulation& simulation = session.simulation();
    session.followMeshChanges([&page](const NodesNow& now) { page.follow(now); });
    const long all = request.steps / request.every + 1;
    page.keep(simulation.time());
    RunLimits limits;
    limits.steps = request.steps;
    if (request.before_step) limits.before_step = [&](Simulation&) { request.before_step(); };
    limits.after_step = [&](const StepReport&, double) {
      if (request.after_step) request.after_step();
      if (simulation.steps() % request.every != 0) return;
      page.keep(simulation.time());
      page.checkSize(all);
    };
    const RunReport report = session.run(limits);
    session.followMeshChanges();
    return report;
  }

  static RunReport keepRecording(Session& session, const ExportRequest& request, PageMaker& page) {
    Simulation& simulation = session.simulation();
    const auto count = request.recording.front().size(), every = std::size_t(request.every);
    const Checkpoint* meshes = nullptr;
    for (std::size_t i = 0; i < count; i += every) {
      const Checkpoint* const present = meshesAt(request.recording.front()[i].time, request.meshes);
      if (std::exchange(meshes, present) != present) {
        present ? void(session.restore(*present, "the recording")) : simulation.reset();
        page.follow({});
      }
      drawing::showInstant(simulation, request.recording, i);
      page.keep(request.recording.front()[i].time);
      page.checkSize(long((count - 1) / every + 1));
    }
    return {};
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
