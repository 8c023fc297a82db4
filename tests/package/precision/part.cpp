#include <softcd/bullet/dispatcher.hpp>

btDispatcher* make_dispatcher_of_part(btCollisionConfiguration* configuration, softcd::bullet::Broadphase& broadphase) {
  return new softcd::bullet::Dispatcher(configuration, broadphase);
}
