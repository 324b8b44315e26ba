// SPDX-License-Identifier: MIT
//
// Says on stderr what goes on, at most every two seconds and nothing of what is done before; and
// what goes on where OpenCASCADE crashes.
#ifndef CAD_PROGRESS_HPP
#define CAD_PROGRESS_HPP

#include <chrono>
#include <string>

namespace cad
{

class Progress
{
  public:
    Progress(std::string input, bool quiet);
    void step(const char *what, std::size_t done = 0, std::size_t of = 0);

  private:
    std::string file;
    bool silent;
    std::chrono::steady_clock::time_point said;
};

// Bounds of what a stranger's file may take, and one line instead of none when it crashes the
// library.
void bound_process(const std::string &input, unsigned seconds);

// Control characters as \xXX, so that no text steers a terminal.
std::string printable(const std::string &text);

} // namespace cad

#endif
