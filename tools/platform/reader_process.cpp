// SPDX-License-Identifier: LGPL-2.1-or-later
// A program of its own rather than a fork: in a process with threads a fork takes along locks that other threads hold,
// of libraries that know nothing of it. posix_spawn needs a millisecond however much memory this process has.
//
// The program gets the file and its arguments on its command line, writes lists to descriptor 3, and prints whatever it
// likes: the first line of that explains how it ended.
#include "framework/scene/reader_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <new>

#include "framework/scene/diagnostics.h"
#include "framework/scene/services.h"

namespace stroma {
namespace {

constexpr int lists_descriptor = 3;
constexpr double megabyte = 1 << 20, base_memory = 256 * megabyte;
constexpr rlim_t base_seconds = 30;

/// Memory that has the calls of a file.
class Buffer {
 public:
  /// Above the descriptors that the program gets other things at, whichever of them are closed here.
  explicit Buffer(const char* name) {
    const int made = memfd_create(name, MFD_CLOEXEC);
    descriptor_ = made < 0 ? -1 : fcntl(made, F_DUPFD_CLOEXEC, lists_descriptor + 1);
    if (made >= 0) close(made);
    if (descriptor_ < 0) throw ComponentError(fmt::format("no memory can be shared: {}", std::strerror(errno)));
  }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;
  ~Buffer() { close(descriptor_); }

  int descriptor() const { return descriptor_; }
  std::string bytes() const {
    struct stat status {};
    if (fstat(descriptor_, &status) != 0) return {};
    std::string bytes(std::size_t(status.st_size), '\0');
    std::size_t at = 0;
    while (at < bytes.size()) {
      const ssize_t read = pread(descriptor_, bytes.data() + at, bytes.size() - at, off_t(at));
      if (read == 0 || (read < 0 && errno != EINTR)) break;
      at += read > 0 ? std::size_t(read) : 0;
    }
    bytes.resize(at);
    return bytes;
  }

 private:
  int descriptor_ = -1;
};

/// What a new process has of this one: no descriptors but those it is given, and no blocked or ignored signals.
class SpawnPlan {
 public:
  SpawnPlan(const Buffer& lists, const Buffer& printed) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_addopen(&actions_, 0, "/dev/null", O_RDONLY, 0);
    for (const int output : {1, 2}) posix_spawn_file_actions_adddup2(&actions_, printed.descriptor(), output);
    posix_spawn_file_actions_adddup2(&actions_, lists.descriptor(), lists_descriptor);
    posix_spawn_file_actions_addclosefrom_np(&actions_, lists_descriptor + 1);
    posix_spawnattr_init(&attributes_);
    sigset_t none, all;
    sigemptyset(&none), sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setsigdefault(&attributes_, &all);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  }
  SpawnPlan(const SpawnPlan&) = delete;
  SpawnPlan& operator=(const SpawnPlan&) = delete;
  ~SpawnPlan() { posix_spawn_file_actions_destroy(&actions_), posix_spawnattr_destroy(&attributes_); }

  pid_t start(Texts words) const {
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    pid_t child = -1;
    const int error = posix_spawn(&child, pointers[0], &actions_, &attributes_, pointers.data(), environ);
    if (error != 0) throw ComponentError(fmt::format("{} cannot be started: {}", words[0], std::strerror(error)));
    return child;
  }

 private:
  posix_spawn_file_actions_t actions_{};
  posix_spawnattr_t attributes_{};
};

/// How it ended, as a sentence; empty when it ended as it should or somebody else has asked already.
std::string endOf(pid_t child) {
  int status = 0;
  pid_t ended = 0;
  while ((ended = waitpid(child, &status, 0)) < 0 && errno == EINTR) {
  }
  if (ended != child) return {};
  if (WIFEXITED(status)) return WEXITSTATUS(status) == 0 ? "" : fmt::format("ended with code {}", WEXITSTATUS(status));
  const int signal = WTERMSIG(status);
  if (signal == SIGXCPU) return "took more computing time than a file of this size needs";
  if (signal == SIGXFSZ) return "made more of it than fits into memory";
  const char* name = sigabbrev_np(signal);
  if (signal == SIGINT || signal == SIGTERM || signal == SIGHUP) return fmt::format("was interrupted (SIG{})", name);
  if (signal == SIGKILL) return "was killed (SIGKILL): by a user, or by the system for lack of memory";
  return fmt::format("crashed on it (SIG{})", name ? name : std::to_string(signal));
}

std::string firstLine(const std::string& text) {
  const std::string line = text.substr(0, std::min<std::size_t>(text.find('\n'), 200));
  return line.empty() ? line : ": " + line;
}

}  // namespace

ValueLists readInOwnProcess(const ReaderProgram& program, const std::string& file, const Texts& arguments) {
  const std::string path = std::filesystem::path(moduleFolder()) / program.name;
  if (access(path.c_str(), X_OK) != 0)
    throw ComponentError(fmt::format("{} is not here: {}", program.reader, howToGet(program.name, program.missing)),
                         path);
  const Buffer lists("lists"), printed("printed");
  Texts words{path, file};
  words.insert(words.end(), arguments.begin(), arguments.end());
  const std::string end = endOf(SpawnPlan(lists, printed).start(std::move(words)));
  const auto fail = [&](const std::string& why) {
    throw ComponentError(fmt::format("{}: {} {}", file.substr(file.rfind('/') + 1), program.reader, why),
                         "a file that is not damaged");
  };
  if (!end.empty()) fail(end + firstLine(printed.bytes()));
  try {
    ValueLists found = ValueLists::fromBytes(lists.bytes());
    const Texts& error = found.get<Texts>("error");
    if (error.size() != 3) return found;
    throw ComponentError(error[0], error[1], error[2]);
  } catch (const ComponentError&) {
    throw;
  } catch (const std::runtime_error& error) {
    fail(fmt::format("returned no valid data ({})", error.what()));
  }
  return {};
}

// ---- in the program ----

namespace {

double memory_limit = 0;

bool writeLists(const std::string& bytes) {
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t written = write(lists_descriptor, bytes.data() + at, bytes.size() - at);
    if (written < 0 && errno != EINTR) return false;
    at += written > 0 ? std::size_t(written) : 0;
  }
  return true;
}

ValueLists errorLists(const std::string& message, const std::string& expected, const std::string& suggestion) {
  ValueLists lists;
  lists.add("error", Texts{message, expected, suggestion});
  return lists;
}

ValueLists listsOf(ReadFunction read, const std::string& file, const Texts& arguments) {
  try {
    return read(file, arguments);
  } catch (const ComponentError& error) {
    return errorLists(error.what(), error.expected, error.suggestion);
  } catch (const std::bad_alloc&) {
    const std::string name = file.substr(file.rfind('/') + 1);
    return errorLists(fmt::format("{} wants more than {:.0f} MB of memory to be read", name, memory_limit / megabyte),
                      "a file that is not damaged", {});
  }
}

}  // namespace

int runReader(int argc, char** argv, ReadFunction read) {
  if (argc < 2 || fcntl(lists_descriptor, F_GETFD) < 0) {
    std::fputs("This program reads a file for Stroma and hands what it finds over at descriptor 3.\n", stderr);
    return 2;
  }
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  const ValueLists lists = listsOf(read, argv[1], {argv + 2, argv + argc});
  // what the library would tidy up at the end is nobody's any more
  _exit(writeLists(lists.bytes()) ? 0 : 3);
}

void limitReader(double file_bytes, double memory_per_byte) {
  memory_limit = base_memory + memory_per_byte * file_bytes;
  const rlim_t seconds = base_seconds + rlim_t(file_bytes / megabyte);
  const rlimit time{seconds, seconds + 1};
  setrlimit(RLIMIT_CPU, &time);
#ifndef __SANITIZE_ADDRESS__  // the sanitizer takes terabytes of it
  const rlimit memory{rlim_t(memory_limit), rlim_t(memory_limit)};
  setrlimit(RLIMIT_DATA, &memory);
  setrlimit(RLIMIT_FSIZE, &memory);
#endif
}

}  // namespace stroma
