# Gives `target` a source file, written when CMake configures, that defines the function
# `const std::string& ertbench::NAME()`: the text of `file`. Whoever calls it declares it.
function(ertbench_embed target file name)
  get_filename_component(file ${file} ABSOLUTE)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
  file(READ ${file} text)
  set(source ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp)
  file(CONFIGURE OUTPUT ${source} @ONLY CONTENT [[
#include <string>

namespace ertbench {

const std::string& @name@() {
  static const std::string text = R"ertbench_text(@text@)ertbench_text";
  return text;
}

}  // namespace ertbench
]])
  target_sources(${target} PRIVATE ${source})
endfunction()
