// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>

#include "framework/mechanics/drawn_segments.h"
#include "tools/view/frame_maker.h"
#include "tools/view/page_numbers.h"
#include "tools/view/viewer.h"

namespace stroma::view {

/// What a page has asked for: its number and its message.
struct Order {
  int client = 0;
  nlohmann::json message;
};

/// A scene that runs in a thread of its own and does what pages ask between steps. No step waits for anybody: while nobody is
/// connected a step costs two reads of atomic variables more than in `stroma run`.
class LiveRun {
 public:
  /// Everything outlives this.
  LiveRun(Session& session, const ViewRequest& request, Audience& audience);
  ~LiveRun() { session_.followMeshChanges(); }

  /// Runs until stop(). Its thread alone uses the session meanwhile.
  void loop();

  // ---- from any thread ----
  void stop();
  /// False when too many wait already. A newer place of a hand replaces one that has not been seen yet.
  bool post(Order order);
  void setDemand(const Demand& demand);
  /// Throws ComponentError for a field or a word of "watch" that there is not.
  void checkWanted(const std::set<int>& fields, const std::set<std::string>& values) const;

 private:
  using Clock = std::chrono::steady_clock;
  bool mustReturn() const {
    return stopping_.load(std::memory_order_relaxed) || ordered_.load(std::memory_order_relaxed);
  }
  /// Those that wait, in their order, for some ten milliseconds: what is left over waits for another step and its picture, so
  /// that a page that asks without end slows nobody. `of_server_only`: pages that come and go, which never wait.
  void doOrders(bool of_server_only = false);
  void answer(const Order& order);
  std::string carryOut(const Order& order);
  void tellProgram(const nlohmann::json& message);
  bool carryOutOfRun(const std::string& verb, const nlohmann::json& message);
  /// Nothing runs that the stop of post() would still have to end.
  void stopIsDone();
  /// Many steps in a row end early for it.
  bool isPauseAsked() const;
  void introduce(int client);
  void sendScene(int client);
  void redraw();
  /// The tree has changed, and everything drawn is rebuilt. Pages get it with the next frame.
  void meshChanged(const NodesNow& now);
  /// It names nodes of a scene that has changed since: what the page does next will be in the numbers of the present one.
  bool isOutdated(const nlohmann::json& message) const;
  void tell(int client, const std::string& verb);
  void tellXml(int client);
  void setAttribute(const nlohmann::json& message);
  void moveObstacle(int client, const nlohmann::json& message);
  void seek(long index);
  /// Of the instant of the recording that comes.
  void takeMeshes(const Checkpoint* meshes);
  void reset();
  void startRunning();
  void advance(long steps);
  void afterStep(const StepReport& report, double seconds);
  /// How far the time of the run is before the clock on the wall that it keeps to [s].
  double secondsAhead() const;
  /// As long as it is before it, unless somebody wants something.
  void waitForRealTime();
  /// There is no result any more: `sentence` says why. A reset begins again.
  void endRun(const std::string& sentence);
  /// An output cannot be written any more.
  void endWithoutOutput(const std::string& sentence);
  void showIfDue();
  void show(const Demand& demand);
  void tellStatus(bool now);
  void lookForDoubts();
  nlohmann::json status() const;
  Demand demand() const;
  double time() const;

  Session& session_;
  const ViewRequest& request_;
  Audience& audience_;
  Simulation& simulation_;
  Drawing drawing_;
  Hands hands_;
  WatchedValues values_;
  FrameMaker frames_;
  std::vector<DrawnSegments::Segment> segments_;  ///< that the drawing was made with
  PageNumbers numbers_;
  std::size_t notes_told_ = 0;  ///< of those that changes of meshes have left
  const Checkpoint* meshes_ = nullptr;  ///< of the recording; null: those of the scene

  // ---- shared with the other threads ----
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Order> orders_;
  Demand demand_;
  bool has_changed_meshes_ = false;  ///< pages may want what is no more
  std::atomic<bool> stopping_ = false, ordered_ = false, can_draw_ = false, connected_ = false;

  // ---- of the thread that steps ----
  bool running_ = false, real_time_ = true;
  double factor_ = 1;
  std::string ended_;   ///< why nothing runs any more, or empty
  bool dirty_ = true;   ///< the picture is another than the one sent last
  int generation_ = 0;  ///< of the scene; 0: nobody has asked for it
  std::size_t replayed_ = 0;
  long run_ = 0;  ///< how often the run has restarted
  std::vector<std::string> doubts_;
  Clock::time_point doubts_due_{};
  bool cells_sent_ = false;
  long frame_ = 0, held_revision_ = -1, index_ = 0;
  StepReport last_;
  double last_step_seconds_ = 0;
  Clock::time_point last_shown_{}, last_status_{}, anchor_{};
  double anchor_time_ = 0;
  /// Of a second or so: what the status tells.
  struct Window {
    Clock::time_point start{};
    double simulated = 0, stepping = 0, copying = 0, fields = 0;
    long steps = 0;
  };
  Window window_;
  nlohmann::json speed_ = nlohmann::json::object();
};

}  // namespace stroma::view
