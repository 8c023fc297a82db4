// The functions that PyBullet's loadPlugin() searches, by names with the postfix "_softcd". They throw nothing.

#include <SharedMemory/SharedMemoryPublic.h>
#include <SharedMemory/plugins/b3PluginAPI.h>
#include <SharedMemory/plugins/b3PluginContext.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <string_view>

#include "commands.hpp"
#include "softcd/error.hpp"

namespace softcd::bullet::pybullet {
namespace {

/// The state that stays from one command to the next.
struct Plugin {
  Session session;
  std::string answer;
  std::string place;         ///< of the answer, for a client in this process
  char problem[1024] = "";   ///< an answer that takes no memory
  b3UserDataValue returned;  ///< the answer
};

/// Returns the number by which Python knows the class of an exception.
int code_of(const std::exception& error) {
  if (dynamic_cast<const InvalidInput*>(&error) != nullptr) return -2;
  if (dynamic_cast<const BackendError*>(&error) != nullptr) return -3;
  const bool is_memory =
      dynamic_cast<const OutOfMemory*>(&error) != nullptr || dynamic_cast<const std::bad_alloc*>(&error) != nullptr;
  return is_memory ? -4 : -1;
}

}  // namespace
}  // namespace softcd::bullet::pybullet

using softcd::bullet::pybullet::code_of;
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

/// Returns 0. Where softcd fails, the answer is the error's text, and the result its class: see code_of(). Answers have
/// at least one byte, as PyBullet wants. PyBullet copies them byte by byte. A client in the same process puts @ before
/// a command and gets the answer's address and size instead, which are valid until the next command.
B3_SHARED_API int executePluginCommand_softcd(b3PluginContext* context, const b3PluginArguments* arguments) {
  Plugin& plugin = *static_cast<Plugin*>(context->m_userPointer);
  context->m_returnData = &plugin.returned;
  try {
    const std::string_view input(reinterpret_cast<const char*>(arguments->m_ints),
                                 sizeof(int) * static_cast<std::size_t>(arguments->m_numInts));
    std::string_view command = arguments->m_text;
    const bool is_near = !command.empty() && command.front() == '@';
    if (is_near) command.remove_prefix(1);
    plugin.answer = execute(plugin.session, *context->m_rpcCommandProcessorInterface, command, input) + "\n";
    std::string& told = is_near ? plugin.place : plugin.answer;
    if (is_near) {
      const auto address = reinterpret_cast<std::uintptr_t>(plugin.answer.data());
      plugin.place = std::to_string(address) + " " + std::to_string(plugin.answer.size()) + "\n";
    }
    plugin.returned = {USER_DATA_VALUE_TYPE_BYTES, static_cast<int>(told.size()), told.data()};
    return 0;
  } catch (const std::exception& error) {
    const int length = std::snprintf(plugin.problem, sizeof plugin.problem, "%s\n", error.what());
    plugin.returned = {USER_DATA_VALUE_TYPE_BYTES, std::min<int>(length, sizeof plugin.problem - 1), plugin.problem};
    return code_of(error);
  }
}

B3_SHARED_API void exitPlugin_softcd(b3PluginContext* context) {
  delete static_cast<Plugin*>(context->m_userPointer);
  context->m_userPointer = nullptr;
}
// NOLINTEND(readability-identifier-naming)

}  // extern "C"
