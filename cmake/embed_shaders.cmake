# Shader texts become part of the binary, so that nothing has to be found at run time.
#
# Included, it gives penumbra_embed_shaders(target). Run with -P, it writes the C++ file from lines "key|path".
if(CMAKE_SCRIPT_MODE_FILE)
    file(STRINGS ${LIST_FILE} entries)
    set(body "")
    foreach(entry IN LISTS entries)
        string(REPLACE "|" ";" entry "${entry}")
        list(GET entry 0 key)
        list(GET entry 1 path)
        file(READ ${path} bytes HEX)
        # Bytes, not a string literal: no quoting, no limit of length, no care for what a file holds.
        string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
        string(LENGTH "${bytes}" length)
        if(length EQUAL 0)
            set(bytes "0x0a,")
        endif()
        string(MAKE_C_IDENTIFIER "${key}" id)
        string(APPEND arrays "const unsigned char ${id}[] = {${bytes}};\n")
        string(APPEND body "        {\"${key}\", text(${id}, sizeof(${id}))},\n")
    endforeach()
    file(WRITE ${OUTPUT}.new "// Written by cmake/embed_shaders.cmake.
#include \"gl/shader_source.h\"

namespace penumbra {
namespace {
${arrays}
[[maybe_unused]] std::string text(const unsigned char* bytes, std::size_t size) {
    return std::string(reinterpret_cast<const char*>(bytes), size);
}
}  // namespace

const ShaderSources& embedded_shaders() {
    static const ShaderSources sources{
${body}    };
    return sources;
}

}  // namespace penumbra
")
    file(COPY_FILE ${OUTPUT}.new ${OUTPUT})
    return()
endif()

set(PENUMBRA_EMBED_SCRIPT ${CMAKE_CURRENT_LIST_FILE})

# Keys: cpp/shaders/lib/a.glsl -> lib/a.glsl, cpp/src/passes/a.vert -> passes/a.vert,
# cpp/src/techniques/pcf/a.frag -> techniques/pcf/a.frag.
function(penumbra_embed_shaders target)
    set(suffixes vert frag geom comp tesc tese glsl)
    set(lines "")
    set(files "")
    foreach(root shaders src/passes src/techniques src/renderer)
        set(patterns "")
        foreach(suffix IN LISTS suffixes)
            list(APPEND patterns ${PROJECT_SOURCE_DIR}/cpp/${root}/*.${suffix})
        endforeach()
        set(base ${PROJECT_SOURCE_DIR}/cpp/src)
        if(root STREQUAL "shaders")
            list(APPEND patterns ${PROJECT_SOURCE_DIR}/cpp/shaders/*.h)
            set(base ${PROJECT_SOURCE_DIR}/cpp/shaders)
        endif()
        file(GLOB_RECURSE found CONFIGURE_DEPENDS ${patterns})
        foreach(path IN LISTS found)
            file(RELATIVE_PATH key ${base} ${path})
            string(APPEND lines "${key}|${path}\n")
            list(APPEND files ${path})
        endforeach()
    endforeach()
    set(list_file ${CMAKE_CURRENT_BINARY_DIR}/shaders.txt)
    set(output ${CMAKE_CURRENT_BINARY_DIR}/embedded_shaders.cpp)
    file(CONFIGURE OUTPUT ${list_file} CONTENT "${lines}" @ONLY)
    add_custom_command(
        OUTPUT ${output}
        COMMAND ${CMAKE_COMMAND} -DLIST_FILE=${list_file} -DOUTPUT=${output} -P ${PENUMBRA_EMBED_SCRIPT}
        DEPENDS ${files} ${list_file} ${PENUMBRA_EMBED_SCRIPT}
        COMMENT "Embedding the shaders"
        VERBATIM)
    target_sources(${target} PRIVATE ${output})
endfunction()
