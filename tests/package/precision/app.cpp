#include <softcd/bullet/dispatcher.hpp>

btDispatcher* make_dispatcher_of_part(btCollisionConfiguration* configuration, softcd::bullet::Broadphase& broadphase);

// Linked at most, never run.
int main(int, char** arguments) {
  auto* configuration = reinterpret_cast<btCollisionConfiguration*>(arguments[0]);
  auto* broadphase = reinterpret_cast<softcd::bullet::Broadphase*>(arguments[1]);
#ifdef WITH_PART
  make_dispatcher_of_part(configuration, *broadphase);
#endif
  const softcd::bullet::Dispatcher dispatcher(configuration, *broadphase);
  return dispatcher.getNumManifolds();
}
