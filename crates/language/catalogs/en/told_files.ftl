### Sentences about files, as they are stored in English: reading, meshes, sizes. Values named what, why, rest, remedy and formats are sentences themselves.
told-why-of = { $what }: { $why }
told-of-name = { $name }: { $why }
told-list = { $why }, { $rest }
told-lists = { $why }; { $rest }
told-list-and = { $why }, and { $rest }
told-mesh-formats = STL, 3MF, OBJ or PLY
told-package-formats = STL or 3MF

## Why a file cannot be read

told-cannot-read-file = cannot read the file
told-no-mesh-file = is no { $formats } file: { $what }
told-truncated = the file is truncated: { $why }
told-truncated-detail = the file is truncated: { $detail }
told-invalid = is not valid { $format }: { $why }
told-invalid-detail = is not valid { $format }: { $detail }
told-too-large = { $what }; at most { $limit } are allowed (limits.{ $key })
told-no-solid = { $name } is no solid: { $why }
told-no-triangles = the mesh has no triangles
told-no-volume = the mesh encloses no volume
told-vertex-not-finite = vertex { $vertex } has a coordinate that is not a finite number
told-triangle-not-finite = triangle { $triangle } has a coordinate that is not a finite number
told-bad-index = triangle { $triangle } names vertex { $vertex }, but there are only { $vertices }
told-far-vertex = vertex { $vertex } of { $name } lies farther than 1.05 km from the origin

## What to do with a file that cannot be read

told-copy-whole-again = Copy the whole file once more; where the original is cut off too, export it from the CAD program again.
told-export-binary = Export it again from the CAD program, as binary { $formats }.
told-make-smaller = Make it smaller, or drop it in several files; or raise limits.{ $key } in the configuration, reload nestd and drop the file again.
told-nothing-to-print-in-it = There is nothing to print in it: export the part itself, as a solid or closed mesh.
told-no-thickness = A surface without thickness cannot be printed: give it a thickness in the CAD program and export it again.
told-move-to-origin = Move the part to the origin in the CAD program, or give the right unit in a ticket; then drop it again.
told-export-part-as = Export the part from the CAD program as { $formats }, and drop that.
told-unpack-formats = Unpack it, and drop the { $formats } files that are in it.
told-unpack-files = Unpack it, and drop the files that are in it.
told-unpack-packages = Unpack it, and drop the packages that are in it.
told-save-plain-text = Save it as plain text (ASCII or UTF-8), or export the part as binary STL.
told-no-shape-in-it = It holds no shape to print: drop the part as { $formats }.
told-get-from-server = Open it in a browser to read what the server said, sign in there, download the part again, and drop that.
told-drop-right-extension = Drop { $formats } files with the right extension; export other formats from the CAD program.
told-copy-again-or-export = Copy it once more; where the original is empty too, export it again.
told-git-lfs-pull = Run `git lfs pull`, then drop it.
told-drop-owner-file = Drop the file that it belongs to.
told-delete-colours = Delete it: the OBJ file is read without colours.
told-export-core = Export the part as plain 3MF (core specification) or as STL.
told-export-from-slicer-or-cad = Export what is to be printed from the slicer or the CAD program as STL, and drop that.
told-export-from-slicer = Export what is to be printed from the slicer as STL, and drop that.
told-beams-to-mesh = Turn the beams into a mesh in the CAD program, and export that.
told-without-password = Save it without a password, and drop that.
told-save-plain-threemf = Open it in the program that wrote it, and save it as a plain 3MF.
told-cut-in-slicer = Cut it out in the slicer (mesh boolean; its export of the object as STL cuts, too), look at the result, and drop that.
told-make-model-volume = Make the volume that is to be printed a part in the slicer, and export it again.
told-same-unit = Say the same unit in both, or drop the package with a ticket that says the unit.
told-export-triangles = Export the part once more with triangles only, or as STL or 3MF.
told-take-out-of-document = Take that out of the document of the package, or drop the model itself with a ticket; then drop it again.

## What a file is in place of a part

told-file-is-empty = the file is empty
told-is-packed-amf = it is a packed AMF file
told-is-zip-named = it is a ZIP package named `.{ $named }`
told-is-text = it is text without `solid`
told-is-no-obj-text = it is no text, as an OBJ file is
told-no-ply-line = it does not begin with the line `ply`
told-first-bytes-no-extension = its first bytes are not known, and its name has no extension
told-first-bytes-nor-name = neither its first bytes nor its name `.{ $extension }` are known
told-is-lfs-pointer = it is a Git LFS pointer, not the file itself
told-is-utf16 = it is UTF-16 text
told-is-off = it is an OFF file
told-is-appledouble = it is an AppleDouble side file of macOS
told-is-step = it is a STEP file
told-is-gltf = it is a glTF file
told-is-xml = it is XML outside a package (AMF?)
told-is-web-page = it is a web page (HTML), not the part itself
told-is-pdf = it is a PDF file
told-is-picture = it is a picture
told-is-archive = it is an archive
told-is-cad = it is a file of a CAD program
told-is-colours = it holds the colours of an OBJ file
told-is-for-printer = it is a file for a printer, not a part
told-is-document = it holds text, not a shape
told-is-of-extension = { $what } (`.{ $extension }`)
told-is-zip-of-parts = it is a ZIP archive with part files in it
told-is-package-in-package = it is a package in a package

## What is wrong in a file

told-bytes-long = it is { $bytes } bytes long
told-separate-pieces = { $name } consists of { $pieces } separate pieces
told-too-many-triangles = it has too many triangles
told-too-many-vertices = it has too many vertices
told-too-many-objects = it has too many objects
told-too-many-components = it has too many components
told-too-many-instances = it has too many component instances
told-too-many-items = it has too many build items
told-too-deep = its components are nested too deeply
told-instances-triangles = all its instances together have too many triangles
told-has-triangles = it has { $count } triangles
told-unpacked-too-large = the unpacked package has too many bytes
told-package-entries = the package has { $count } entries
told-package-encrypted = the package is encrypted
told-package-damaged = the ZIP package is damaged: { $detail }
told-package-packed = the package is packed in a way that 3MF does not allow: { $detail }
told-zip-end-missing = the end of the ZIP package is missing
told-no-relationships = the package has no relationships, so no 3D model
told-no-model = the package has no 3D model
told-no-build-items = it has no build items, so nothing to print
told-no-item-to-print = none of its build items is a part to print
told-no-object = there is no object { $object }
told-component-of-itself = object { $object } is a component of itself
told-beam-lattice = object { $object } is a beam lattice: its shape is in beams, not in triangles
told-extension-required = the file requires { $what } that is not supported: { $name }
told-an-extension = an extension
told-encrypted-content = encrypted content
told-negative-volume = { $name } has the negative volume { $volume }: it is to be cut out, and nestd does not cut
told-no-model-volume = { $name } has no model volume, only { $left }
told-manifest-unit = its unit is { $unit }, and the manifest says { $other }
told-header-too-short = { $bytes } bytes are too few for a binary STL header
told-only-triangles = only { $present } of { $count } triangles are in the file
told-second-stl = a second STL follows the { $count } triangles of the first
told-ascii-follows = an ASCII STL follows its { $count } triangles
told-more-triangles-follow = { $count } triangles are counted, but { $more } more follow
told-ends-within-facet = it ends within facet { $number }
told-ends-within-vertex = it ends within a vertex
told-ends-within-line = it ends within line { $number }
told-ends-in-line = it ends in line { $number }, before { $wanted }
told-line-why = line { $number }: { $why }
told-facet-vertices = facet { $number } has { $found } vertices instead of 3
told-expected-found = expected { $wanted }, found { $found }
told-unfinished-copy = it is an unfinished copy, { $why }
told-ends-in-zeros = which ends in zeros
told-zeros-from = with nothing but zeros from byte { $at } on
told-zeros-in-line = with zeros in line { $number }
told-last-zeros = whose last { $run } of { $count } triangles are zeros
told-zeros-between = whose triangles { $first } to { $last } of { $count } are zeros
told-no-face = it holds no face: points and lines have nothing to print
told-no-face-points = it holds no face: points have nothing to print
told-free-form-surface = it holds a free-form surface
told-free-form-curve = it holds a free-form curve
told-names-other-file = it names another file that belongs to it
told-in-line = { $what } (line { $number })
told-ends-before-header = it ends before its `end_header`
told-entries-of = it has { $count } of { $all } entries of element { $name }

## Why a part cannot be printed on a machine

told-not-closed = { $name }: the mesh is not closed ({ $why }), so it is not known what is inside. It is not mended, because { $rest }. Repair it, or set mesh_errors = "warn" in the machine { $machine }.
told-mendable = { $name }: the mesh is not closed ({ $why }), so it is not known what is inside. It can be mended: { $what }. { $remedy }
told-mend-remedy = `nestd mend { $part }` or the button on its page has it mended and printed.
told-mend-remedy-ticket = A ticket with mend = true has it mended and printed.
told-mend-holes =
    { $n ->
        [one] { $n } hole of at most { $mm } mm closed
       *[other] { $n } holes of at most { $mm } mm closed
    }
told-mend-added =
    { $n ->
        [one] { $n } triangle added
       *[other] { $n } triangles added
    }
told-mend-turned =
    { $n ->
        [one] { $n } triangle turned
       *[other] { $n } triangles turned
    }
told-mend-left-out =
    { $n ->
        [one] { $n } triangle left out
       *[other] { $n } triangles left out
    }
told-mend-joined =
    { $n ->
        [one] { $n } corner joined
       *[other] { $n } corners joined
    }
told-mend-volume = volume { $before } -> { $now } cm³
told-mend-off = at most { $mm } mm off the surface before
told-not-mended-closed = it is closed
told-not-mended-too-large = it has too many triangles or holes
told-not-mended-ambiguous = which triangles belong together is not known where more than two meet in an edge
told-not-mended-one-sided = a piece of it has one side only
told-not-mended-large-hole = a hole { $mm } mm wide is too large to know what was there
told-not-mended-opening = an opening { $mm } mm wide has sharp edges all around and may be meant
told-not-mended-crossing = what would close its holes would cross its surface
told-not-mended-doubt = the surface bends too much around its holes to know what was there
told-not-mended-sheet = a piece of it is a sheet without a volume
told-not-mended-cavity = whether a piece inside another is a cavity is not known
told-open-edges =
    { $n ->
        [one] { $n } open edge
       *[other] { $n } open edges
    }
told-non-manifold-edges =
    { $n ->
        [one] { $n } edge of more than two triangles
       *[other] { $n } edges of more than two triangles
    }
told-inconsistent-edges =
    { $n ->
        [one] { $n } edge whose triangles face opposite ways
       *[other] { $n } edges whose triangles face opposite ways
    }
told-too-many-copies = It asks for { $copies } copies; one file may ask for { $limit } at most (limits.max_copies). Drop it again with fewer, or raise that limit in the configuration and reload nestd.
told-needs-more-room = { $name }: needs { $x } x { $y } x { $z } mm in its best allowed orientation ({ $rule }); the build volume of { $machine } is { $a } x { $b } x { $c } mm. { $remedy }
told-larger-machine = Drop it for a larger machine, or split it; where its ticket holds it upright or fixed, a freer orientation may fit.
told-other-unit-fits = Read in { $unit }s it would be { $x } x { $y } x { $z } mm and fit: if that is meant, drop it with a ticket that says unit = "{ $unit }".
told-no-rotation = { $name }: no rotation obeys all of its orientation rules ({ $rule }). Take one of them out of its ticket and drop both again.
told-no-place-alone = It was tried and found no place in the empty build volume of { $machine }. Drop it for a larger machine, or with a freer orientation or a smaller clearance_mm in its ticket.
told-search-failed = The search failed on it: { $detail }. Take it back to try once more; where that fails too, export it again.
told-reader-failed = The reader failed on it: { $detail }. Export it again, as { $formats }; where that fails too, send it to nestd's makers.
told-read-timeout = { $name }: reading it ended nestd twice, and then a separate process had not read it after { $minutes } minutes. Export it with fewer triangles or pieces and drop it again.
told-read-crash = { $name }: reading it ended nestd twice, and then a separate process with { $bytes } bytes of memory (limits.read_memory_bytes) ended { $what }. Export it with fewer triangles or pieces and drop it again, or raise that limit and take it back.
told-by-signal = by signal { $signal }
told-with-exit-code = with exit code { $code }
told-file-not-kept = Its file is no longer kept. Drop it again.
told-file-not-here = The file is not here, for nestd does not have it whole any more: { $detail }.
told-size-differs = { $name } was { $before } mm when it was first read, and is { $now } mm now
told-mend-differs = the mesh of { $name } is not mended now as it was when it was first read
told-stored-missing = the stored file of { $name } is not there
told-stored-damaged = the stored file of { $name } was damaged and is set aside as { $aside }

## Warnings about a file

told-mesh-not-closed = The mesh is not closed: { $why }.
told-mended-by = The mesh was mended, as { $who } allows: { $what }.
told-mended-by-person = The mesh was mended, as { $name } allows: { $what }.
told-mend-by-ticket = its ticket
told-mend-by-setting = mesh_errors of its machine
told-far-from-origin = Its coordinates are so far from the origin of the file that 32-bit numbers are { $step } mm apart there: its details may be off by as much. Move it to the origin in the CAD program and export it again.
told-turned-inside-out = the surface was inside out and has been turned
told-suspicious-size = suspicious size: the largest extent is { $size } mm as read in { $unit }; it would be { $detail }
told-no-endsolid = the file has no `endsolid`: its end may be missing
told-several-solids = the file holds { $solids } solids; they are one part of { $facets } triangles
told-objects-one-part = the file holds { $objects } objects; they are one part
told-bytes-ignored =
    { $n ->
        [one] { $n } byte after the last triangle is ignored
       *[other] { $n } bytes after the last triangle are ignored
    }
told-duplicate-pieces = duplicate pieces are at the same place: one of each is kept, { $left } triangles are left out
told-ticket-unit-used = the ticket's unit { $unit } is used instead of the file's { $other }
told-left-out-volumes = left out, as no model volume: { $names }
told-slice-stack = the file also has this part as a slice stack, which is ignored: its triangles may be only an approximation
told-left-out-unprintable =
    { $n ->
        [one] { $n } build item is marked as not printable and left out
       *[other] { $n } build items are marked as not printable and left out
    }
told-left-out-helpers =
    { $n ->
        [one] { $n } build item is supports or another helper, not parts, and left out
       *[other] { $n } build items are supports or other helpers, not parts, and left out
    }
told-items-touch = { $why }, and each item would be a part of its own, placed anywhere (items that belong together must be dropped joined, as one object or as STL)
told-items-stacked =
    { $stacked } of its { $n ->
        [one] { $n } build item lies
       *[other] { $n } build items lie
    } in one place
told-item-touches = in the file it touches or passes through { $name }
told-too-many-items-to-see = the file has too many build items to see whether they touch

## What a person must confirm

told-is-speck = it is { $x } x { $y } x { $z } mm, smaller than { $least } mm
told-is-speck-inches = it is { $x } x { $y } x { $z } mm, smaller than { $least } mm; read in inches instead of millimetres it would be { $a } x { $b } x { $c } mm
told-is-thin = it is { $x } x { $y } x { $z } mm, thinner than a layer of { $layer } mm

## Why a ZIP archive was not unpacked

told-archive-cannot = This archive cannot be unpacked: { $detail }. Pack it once more as an ordinary ZIP file without a password, or unpack it and drop the folder.
told-archive-twice = This archive names a file twice. Unpack it, and drop the folder.
told-archive-names-twice = This archive names "{ $name }" twice. Unpack it, and drop the folder.
told-archive-too-large = This archive unpacks to more than the limit (`max_unpacked_bytes` = { $limit }, and { $times } times its size for a file). Unpack it, and drop the folder.
told-archive-entries = This archive has { $entries } entries; the limit is { $limit } (`max_entries`). Unpack it, and drop the folder.
told-archive-in-archive = This archive has another archive in it, "{ $name }". Unpack both, and drop the folder.
told-archive-empty = This archive has no file in it. Pack the parts into it, and drop it again.
told-archive-outside = This archive names a file outside of it, "{ $name }". Unpack it, and drop the files that are meant.
told-archive-link = This archive names a link, "{ $name }". Unpack it, and drop the files that are meant.
