"""The measured rig: a large motor heated near standstill. Its raw logs become runs that `motor-fmu close-loop` reads."""
