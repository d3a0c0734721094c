// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/closed_pipes.h"

#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>

namespace stroma::command {
namespace {

struct Stream {
  const int descriptor;
  const bool is_terminal = isatty(descriptor);  // one that hung up is none any more
};

/// As fopencookie() wants it: how many bytes went, 0 when none could.
ssize_t writeOrDrop(void* cookie, const char* bytes, std::size_t count) {
  const Stream& stream = *static_cast<const Stream*>(cookie);
  std::size_t done = 0;
  while (done < count) {
    const ssize_t written = ::write(stream.descriptor, bytes + done, count - done);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno == EPIPE || (errno == EIO && stream.is_terminal) ? ssize_t(count) : ssize_t(done);
    done += std::size_t(written);
  }
  return ssize_t(done);
}

void replace(std::FILE*& file, Stream& stream, int buffering) {
  std::FILE* const other = ::fopencookie(&stream, "w", {nullptr, writeOrDrop, nullptr, nullptr});
  if (!other) return;
  std::fflush(file);
  std::setvbuf(other, nullptr, buffering, BUFSIZ);
  file = other;
}

}  // namespace

void outliveReaders() {
  static Stream out{STDOUT_FILENO}, err{STDERR_FILENO};
  std::signal(SIGPIPE, [](int) {});  // unlike SIG_IGN it is not inherited by programs that are started
  replace(stdout, out, out.is_terminal ? _IOLBF : _IOFBF);
  replace(stderr, err, _IONBF);
}

}  // namespace stroma::command
