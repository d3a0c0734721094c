// SPDX-License-Identifier: LGPL-2.1-or-later
// The number of threads of a run: a given one, or chosen from the size of the scene. No result depends on it.
#pragma once
#include <string>

#include "framework/simulation/simulation.h"

namespace stroma {

/// Nodes per thread below which another thread is not worth its processor time (docs/scale.md, "Threads").
constexpr Index nodes_per_thread = 4000;
/// As many threads as pay for so many nodes, at most `most`.
int threadsThatPay(Index nodes, int most);

/// Sets the number of threads for all scenes of this process.
void giveThreads(int count);
/// On: sessions choose the number for each scene that they load or step, up to usableCores(). Off: one thread. No effect after
/// giveThreads(), nor if the environment variable STROMA_THREADS gives the number. Returns what it was before. Throws
/// std::invalid_argument if that variable is not a number from 1 to 1024.
bool chooseThreads(bool on);
/// Sets the number for this simulation, if it is chosen.
void takeThreadsFor(const Simulation& simulation);

/// "2 of 16, ...": the number for this simulation, and why.
std::string threadsText(const Simulation& simulation);

}  // namespace stroma
