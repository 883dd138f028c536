// The myrialux program.
#include <cstdio>

int main() {
  std::puts("myrialux " MYRIALUX_VERSION);
  return 0;
}
