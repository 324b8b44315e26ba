// SPDX-License-Identifier: MIT
#include "progress.hpp"

#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <utility>

namespace cad
{

static char crash_line[512], late_line[512]; // a handler has nothing else to look at

Progress::Progress(std::string input, bool quiet)
    : file(std::move(input)), silent(quiet), said(std::chrono::steady_clock::now())
{
}

void Progress::step(const char *what, std::size_t done, std::size_t of)
{
    std::snprintf(crash_line, sizeof crash_line,
                  "raymap-step: %.300s: OpenCASCADE crashed while %s (signal ",
                  printable(file).c_str(), what);
    std::snprintf(late_line, sizeof late_line,
                  "raymap-step: %.300s: given up while %s: it took more than the time limit "
                  "(--seconds)\n",
                  printable(file).c_str(), what);
    const auto now = std::chrono::steady_clock::now();
    if (silent || now - said < std::chrono::seconds(2))
        return;
    said = now;
    std::string line = printable(file) + ": " + what;
    if (done > 0)
        line += " " + std::to_string(done) + (of > 0 ? " of " + std::to_string(of) : "");
    std::fprintf(stderr, "%s\n", line.c_str());
}

std::string printable(const std::string &text)
{
    std::string out;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte < 0x20 || byte == 0x7f) {
            char code[8];
            std::snprintf(code, sizeof code, "\\x%02x", byte);
            out += code;
        } else {
            out += c;
        }
    }
    return out;
}

extern "C" {
static void crashed(int signal_number)
{
    char end[8] = {static_cast<char>('0' + signal_number / 10),
                   static_cast<char>('0' + signal_number % 10), ')', '\n'};
    if (write(STDERR_FILENO, crash_line, std::strlen(crash_line)) > 0 &&
        write(STDERR_FILENO, end, 4) > 0)
        signal_number = signal_number + 0;
    raise(signal_number); // its default, since SA_RESETHAND
}

static void late(int)
{
    const ssize_t written = write(STDERR_FILENO, late_line, std::strlen(late_line));
    _exit(written > 0 ? 3 : 5);
}
}

static void bound(int what, rlim_t most)
{
    rlimit now;
    if (getrlimit(static_cast<__rlimit_resource_t>(what), &now) != 0)
        return;
    now.rlim_cur = std::min(now.rlim_cur, most);
    setrlimit(static_cast<__rlimit_resource_t>(what), &now);
}

void bound_process(const std::string &input, unsigned seconds)
{
    struct stat info;
    const rlim_t size = stat(input.c_str(), &info) == 0 ? static_cast<rlim_t>(info.st_size) : 0;
    constexpr rlim_t gib = 1024UL * 1024 * 1024;
    bound(RLIMIT_AS, 6 * gib + 256 * size);
    bound(RLIMIT_CPU, 600 + size / 20000);
    bound(RLIMIT_FSIZE, 4 * gib + 256 * size);
    bound(RLIMIT_CORE, 0);
    static char stack[65536];
    stack_t other{};
    other.ss_sp = stack;
    other.ss_size = sizeof stack;
    sigaltstack(&other, nullptr);
    struct sigaction action {
    };
    action.sa_handler = crashed;
    action.sa_flags = static_cast<int>(SA_ONSTACK | SA_RESETHAND | SA_NODEFER);
    for (const int number : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT})
        sigaction(number, &action, nullptr);
    action.sa_handler = late;
    for (const int number : {SIGXCPU, SIGALRM})
        sigaction(number, &action, nullptr);
    // By the clock, too: what waits for something uses no time of the processor.
    alarm(seconds > 0 ? seconds
                      : static_cast<unsigned>(std::min<rlim_t>(3600 + size / 5000, 86400)));
}

} // namespace cad
