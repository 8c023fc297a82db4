#include "program.hpp"

int main(int argc, char** argv) {
  return softcd::demo::detect_program(argc, argv);
}
