// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/python/termination.h"

#include <dlfcn.h>

#include <atomic>

#include "tools/session/session.h"

namespace stroma::python {
namespace {

/// The session that signals stop, and what they did before: of the program, or nothing.
std::atomic<Session*> stopped{nullptr};
struct sigaction interrupt_before, termination_before;
std::atomic<int> at_work{0};  ///< how many know what SIGTERM does
std::atomic<void (*)(int)> of_metis{nullptr};

bool hasHandler(const struct sigaction& action) {
  return !(action.sa_flags & SA_SIGINFO) && action.sa_handler != SIG_DFL && action.sa_handler != SIG_IGN;
}

void onInterrupt(int number) {
  if (Session* session = stopped.load()) session->requestStop();
  interrupt_before.sa_handler(number);
}

void onTermination(int number) {
  if (Session* session = stopped.load()) session->requestStop();
  termination_before.sa_handler(number);
}

/// Puts `handler` in the place of what `signal` does now, which is kept. False: the program has no handler, and nothing is done.
bool replace(int number, void (*handler)(int), struct sigaction& before) {
  struct sigaction present {};
  if (sigaction(number, nullptr, &present) != 0 || !hasHandler(present)) return false;
  if (present.sa_handler != handler) before = present;  // else METIS, left by a run that was stopped, has put ours back
  struct sigaction now = before;
  now.sa_handler = handler;
  return sigaction(number, &now, nullptr) == 0;
}

/// SIGTERM that METIS would have taken. Safe in a handler.
void handOn() {
  if (at_work > 0 && hasHandler(termination_before)) {
    sigaction(SIGTERM, &termination_before, nullptr);  // METIS has put a handler there that is called once
    onTermination(SIGTERM);
  } else if (at_work == 0 || termination_before.sa_handler != SIG_IGN) {
    std::signal(SIGTERM, SIG_DFL);
    std::raise(SIGTERM);
  }
}

/// METIS's own, which it has for what is not SIGTERM. Looked for outside of a handler, when it is there; that takes a while.
void findMetis() {
  if (of_metis.load()) return;
  if (void* metis = dlopen("libmetis.so.5", RTLD_NOLOAD | RTLD_LAZY))
    of_metis = reinterpret_cast<void (*)(int)>(dlsym(metis, "gk_sigthrow"));
}

}  // namespace

void standBeforeMetis() {
  Dl_info here{};
  if (dladdr(reinterpret_cast<void*>(&standBeforeMetis), &here) != 0 && here.dli_fname)
    dlopen(here.dli_fname, RTLD_NOLOAD | RTLD_LAZY | RTLD_GLOBAL);
}

EndingSignals::EndingSignals(Session* session, bool heeds_interrupts) {
  is_first_ = at_work.fetch_add(1) == 0, has_session_ = session != nullptr;
  if (struct sigaction present {}; is_first_ && sigaction(SIGTERM, nullptr, &present) == 0 && present.sa_handler != onTermination)
    termination_before = present;
  if (!session) findMetis();
  Session* none = nullptr;
  if (!session || !stopped.compare_exchange_strong(none, session)) return;
  heeds_interrupts_ = heeds_interrupts && replace(SIGINT, onInterrupt, interrupt_before);
  heeds_termination_ = heeds_interrupts && replace(SIGTERM, onTermination, termination_before);
  if (!heeds_interrupts_ && !heeds_termination_) stopped = nullptr;
}

EndingSignals::~EndingSignals() {
  if (!has_session_) findMetis();  // of a scene that was loaded, which has opened it if it ever does
  if (heeds_interrupts_) sigaction(SIGINT, &interrupt_before, nullptr);
  if (heeds_termination_) sigaction(SIGTERM, &termination_before, nullptr);
  if (is_first_ && hasHandler(termination_before)) {  // METIS puts back what was there without its flags
    struct sigaction now {};
    if (sigaction(SIGTERM, nullptr, &now) == 0 && now.sa_handler == termination_before.sa_handler)
      sigaction(SIGTERM, &termination_before, nullptr);
  }
  if (heeds_interrupts_ || heeds_termination_) stopped = nullptr;
  --at_work;
}

}  // namespace stroma::python

/// In front of the function of METIS with this name: see termination.h.
extern "C" __attribute__((visibility("default"))) void gk_sigthrow(int number) {
  using namespace stroma::python;
  if (number == SIGTERM) return handOn();
  if (auto* metis = of_metis.load()) metis(number);
}
