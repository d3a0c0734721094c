// SPDX-License-Identifier: LGPL-2.1-or-later
// Signals that end a run, and METIS. While METIS orders a matrix it takes SIGTERM for an error of its own: in the thread that works
// it gives up, and the program would go on; in another thread, as those of a BLAS are, the process would crash. Its handler is the
// function gk_sigthrow(), which this module has too, and in front: the signal is handed on to whom it was meant for.
#pragma once
#include <csignal>

namespace stroma {
class Session;
}

namespace stroma::python {

/// Puts this module's gk_sigthrow() in front of that of METIS, which is loaded later. Called once, when the module is.
void standBeforeMetis();

/// As long as it lives, SIGTERM has the meaning that it has for the program now, also while METIS orders a matrix. With a session:
/// Ctrl-C, where `heeds_interrupts`, and SIGTERM, where the program has a handler for it, end its run at once. The program is
/// told too, and acts when the run has ended.
class EndingSignals {
 public:
  explicit EndingSignals(Session* session = nullptr, bool heeds_interrupts = false);
  ~EndingSignals();
  EndingSignals(const EndingSignals&) = delete;

 private:
  bool is_first_ = false, has_session_ = false, heeds_interrupts_ = false, heeds_termination_ = false;
};

}  // namespace stroma::python
