// SPDX-License-Identifier: LGPL-2.1-or-later
// Starts a program many times at the price of a fork. Loaded into it by LD_PRELOAD, this stops it where main would begin, and waits
// for requests. A child of its own answers each: it goes on into main with the arguments, environment, folder and files of the request.
// So the dynamic linker's work for the program and for the library STROMA_TEST_OPENED is done once. tests/support/started.py asks.
//
// A request is a packet on the socket STROMA_TEST_SOCKET: the number of arguments, the folder, the arguments and the environment, each
// ended by a zero byte; with three files: input, output, errors. Two packets answer: the child's number, and how it ended (waitpid).
#include <dlfcn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <vector>

namespace {

using Main = int (*)(int, char**, char**);

struct Request {
  std::vector<char> text;
  std::vector<char*> arguments, environment;
  char* folder = nullptr;
  int files[3] = {-1, -1, -1};
};

bool receive(int socket, Request& request) {
  request.text.resize(1 << 18);
  iovec part = {request.text.data(), request.text.size()};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof request.files)];
  msghdr message = {};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  const ssize_t size = recvmsg(socket, &message, 0);
  if (size <= 0) return false;
  const cmsghdr* header = CMSG_FIRSTHDR(&message);
  const bool cut = (message.msg_flags & (MSG_TRUNC | MSG_CTRUNC)) != 0;
  if (cut || header == nullptr || header->cmsg_len != CMSG_LEN(sizeof request.files)) _exit(70);
  std::memcpy(request.files, CMSG_DATA(header), sizeof request.files);
  std::vector<char*> words;
  for (char* word = request.text.data(); word < request.text.data() + size; word += std::strlen(word) + 1)
    words.push_back(word);
  const int count = std::atoi(words.at(0));
  request.folder = words.at(1);
  request.arguments.assign(words.begin() + 2, words.begin() + 2 + count);
  request.arguments.push_back(nullptr);
  request.environment.assign(words.begin() + 2 + count, words.end());
  request.environment.push_back(nullptr);
  return true;
}

// In the child: as after execve.
void become(const Request& request) {
  for (int k = 0; k < 3; ++k) {
    if (dup2(request.files[k], k) < 0) _exit(71);
    close(request.files[k]);
  }
  if (chdir(request.folder) != 0) _exit(72);
  clearenv();
  for (char* entry : request.environment)
    if (entry != nullptr) putenv(entry);
}

// Returns in each child; the parent goes when nobody asks any more.
const Request& served(int socket) {
  auto& request = *new Request;  // outlives main
  while (receive(socket, request)) {
    const pid_t child = fork();
    if (child == 0) {
      close(socket);
      become(request);
      return request;
    }
    for (int file : request.files) close(file);
    int status = 0;
    if (child < 0 || send(socket, &child, sizeof child, MSG_NOSIGNAL) < 0 || waitpid(child, &status, 0) != child)
      _exit(73);
    if (send(socket, &status, sizeof status, MSG_NOSIGNAL) < 0) break;
  }
  _exit(0);
}

}  // namespace

extern "C" __attribute__((visibility("default"))) int __libc_start_main(Main entry, int count, char** values, Main init,
                                                                        void (*fini)(), void (*end)(), void* stack) {
  using Start = int (*)(Main, int, char**, Main, void (*)(), void (*)(), void*);
  const auto start = reinterpret_cast<Start>(dlsym(RTLD_NEXT, "__libc_start_main"));
  if (const char* socket = std::getenv("STROMA_TEST_SOCKET")) {
    // where it is not there, its users open it themselves
    if (const char* library = std::getenv("STROMA_TEST_OPENED")) dlopen(library, RTLD_NOW | RTLD_LOCAL);
    const Request& request = served(std::atoi(socket));
    count = static_cast<int>(request.arguments.size()) - 1;
    values = const_cast<char**>(request.arguments.data());
  }
  return start(entry, count, values, init, fini, end, stack);
}
