// SPDX-License-Identifier: LGPL-2.1-or-later
// The module's door: a live view, or a page of a whole run.
#include <fmt/format.h>

#include <cmath>

#include "framework/scene/abi.h"
#include "framework/scene/output_file.h"
#include "framework/scene/services.h"
#include "tools/drawing/recording.h"
#include "tools/units/unit_system.h"
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
      : request_(request), drawing_(drawingOf(simulation)), frames_(simulation, drawing_) {
    demand_.all_nodes = request.inside;
    demand_.fields = fieldsCalled(request.fields, drawing_);
    Packet scene = scenePacket(simulation, drawing_, 1, "recording");
    demand_.contacts = !drawing_.contacts.empty();
    for (const Field& field : drawing_.fields)  // of several with the name any will do
      if (!request.fields.empty() && field.name == request.fields.front())
        scene.header()["view"] = {{"colour", field.name + (field.source ? "|cells|" : "|nodes|") +
                                                 unitsOf(simulation.scene()).unit(drawing::unitOf(field))},
                                  {"range", "most"}};
    page_.add(scene.bytes());
    page_.add(heldPacket(simulation, drawing_, 1, simulation.time()).bytes());
    if (request.inside) page_.add(cellsPacket(drawing_, 1).bytes());
    opening_ = page_.size();
  }

  void keep(double time) {
    auto packet = frames_.make(demand_, ++pictures_, time, true);
    packet->header()["generation"] = 1;
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

  const ExportRequest& request_;
  Drawing drawing_;
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
                                                       : keepRecording(session.simulation(), request, page);
    if (report.end == RunEnd::done) page.write();
    return report;
  }

 private:
  static RunReport keepRun(Session& session, const ExportRequest& request, PageMaker& page) {
    const Simulation& simulation = session.simulation();
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
    return session.run(limits);
  }

  static RunReport keepRecording(Simulation& simulation, const ExportRequest& request, PageMaker& page) {
    const auto count = request.recording.front().size(), every = std::size_t(request.every);
    for (std::size_t i = 0; i < count; i += every) {
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
