// What PyBullet's loadPlugin() looks for, by names with the postfix "_softcd". No exception leaves a function.

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

/// What stays from one command to the next.
struct Plugin {
  Session session;
  std::string answer;
  char problem[1024] = "";   ///< an answer that takes no memory
  b3UserDataValue returned;  ///< the answer
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

/// 0, or -1 where the answer is what went wrong. Answers have at least one byte, as PyBullet wants.
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
