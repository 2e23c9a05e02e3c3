// Reads frames from UDP, one a datagram of float32 in volts, and writes the contacts of each as a
// line of JSON. The first frame is the reference: nothing may press.
//
//     udp_contacts SOLVER.ert PORT
#include <netinet/in.h>
#include <sys/socket.h>

#include <cstdio>
#include <cstdlib>
#include <exception>

#include "runtime/runtime.h"

using namespace ertbench::runtime;

int main(int count, char** words) try {
  if (count != 3) return std::fprintf(stderr, "usage: udp_contacts SOLVER.ert PORT\n"), 2;
  Solver solver = Solver::load(words[1]);
  const int port = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<in_port_t>(std::atoi(words[2])));
  if (bind(port, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) {
    return std::perror("udp_contacts"), 2;
  }
  bool is_first = true;
  const auto read = [&](std::span<float> voltages) {
    ssize_t bytes = 0;  // a datagram of another size is no frame; an empty one ends
    do bytes = recv(port, voltages.data(), voltages.size_bytes(), MSG_TRUNC);
    while (bytes > 0 && bytes != static_cast<ssize_t>(voltages.size_bytes()));
    if (is_first && bytes > 0) solver.set_reference(voltages);
    return is_first = false, bytes > 0;
  };
  stream(solver, read, [](std::span<const Contact> contacts, std::span<const float>) {
    std::printf("{\"contacts\": [");
    for (const Contact& one : contacts) {
      std::printf("%s{\"x_mm\": %.2f, \"y_mm\": %.2f, \"strength\": %.4g}",
                  &one == contacts.data() ? "" : ", ", one.x_mm, one.y_mm, one.strength);
    }
    std::printf("]}\n");
    std::fflush(stdout);
  });
} catch (const std::exception& error) {
  return std::fprintf(stderr, "udp_contacts: %s\n", error.what()), 2;
}
