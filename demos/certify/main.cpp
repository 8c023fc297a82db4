#include "program.hpp"

int main(int argc, char** argv) {
  return softcd::demo::certify_program(argc, argv);
}
