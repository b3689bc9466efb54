# The type supports are many small sources that all read the same large headers; compiled in batches they take half the
# time. The generators not named here repeat names between sources, which keeps theirs apart.
function(compile_in_batches)
  foreach(kind c cpp fastrtps_c fastrtps_cpp introspection_c)
    set(target ${PROJECT_NAME}__rosidl_typesupport_${kind})
    if(TARGET ${target})
      set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 12)
    endif()
  endforeach()
endfunction()
