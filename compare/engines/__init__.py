"""One file per engine; the file is the engine.

An engine file, ours or a user's, has at module level

    METHODS   the names of its integrators, the default first
    FEATURES  the force laws it can express exactly, of: gravity, tether, drag, floor
    ABOUT     a dict: version, precision, switched_off (a list of what was switched off to be fair)

and four verbs on whole states (N, 13) of design.md, section 3:

    build(scene, method) -> world    untimed; switches off all that the scene has not got;
                                     NotImplementedError(why) where the engine cannot do this scene
    write(world, states)             the states into the world; forgets all history
    advance(world, n, dt)            n steps of dt in the engine's native loop: the only timed call
    read(world) -> states            (N, 13)

Three more lists where they are not empty: ADAPTIVE, methods that choose their own steps and are named METHOD@TOLERANCE
(METHOD alone takes its own default); WHOLE, methods that take a flight of any length in one step; ON_REQUEST, names
that take part only when asked for.

And three more verbs if it wishes

    audit(world) -> list[str]        what went wrong silently since write
    vertices(world, points)          where body points (n, 3) of a body that is no longer rigid are: (N, n, 3);
                                     without it the harness computes them from the state
    remark(world) -> str             what the user should know and is no fault: which method was chosen, and why

An engine file imports nothing of ours that a user's own could not: it reads the attributes of the scene it is given
(`scenarios/scene.py`), except that our own solver's file imports `solver`.
"""
