// The functions that PyBullet's loadPlugin() searches, by names with the postfix "_softcd". They throw nothing.

#include <SharedMemory/SharedMemoryPublic.h>
#include <SharedMemory/plugins/b3PluginAPI.h>
#include <SharedMemory/plugins/b3PluginContext.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>

#include "commands.hpp"

namespace softcd::bullet::pybullet {
namespace {

/// The state that stays from one command to the next.
struct Plugin {
  Session session;
  std::string answer;
  char problem[1024] = "";   ///< a text that needs no allocation
  b3UserDataValue returned;  ///< the command's result
};

}  // namespace
}  // namespace softcd::bullet::pybullet

using softcd::bullet::pybullet::Plugin;

extern "C" {

// NOLINTBEGIN(readability-identifier-naming): PyBullet's names.
B3_SHARED_API int initPlugin_softcd(b3PluginContext* context) {
  try {
    context->m_userPointer = new Plugin;
  } catch (const std::exception&) {
    return -1;
  }
  return SHARED_MEMORY_MAGIC_NUMBER;
}

/// Returns 0, or -1 if the result is an error's text. Results have at least one byte, as PyBullet requires.
B3_SHARED_API int executePluginCommand_softcd(b3PluginContext* context, const b3PluginArguments* arguments) {
  Plugin& plugin = *static_cast<Plugin*>(context->m_userPointer);
  context->m_returnData = &plugin.returned;
  try {
    plugin.answer = execute(plugin.session, *context->m_rpcCommandProcessorInterface, arguments->m_text) + "\n";
    plugin.returned = {USER_DATA_VALUE_TYPE_BYTES, static_cast<int>(plugin.answer.size()), plugin.answer.data()};
    return 0;
  } catch (const std::exception& error) {
    const int length = std::snprintf(plugin.problem, sizeof plugin.problem, "%s\n", error.what());
    plugin.returned = {USER_DATA_VALUE_TYPE_BYTES, std::min<int>(length, sizeof plugin.problem - 1), plugin.problem};
    return -1;
  }
}

B3_SHARED_API void exitPlugin_softcd(b3PluginContext* context) {
  delete static_cast<Plugin*>(context->m_userPointer);
  context->m_userPointer = nullptr;
}
// NOLINTEND(readability-identifier-naming)

}  // extern "C"
