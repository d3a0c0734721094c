;; SPDX-License-Identifier: LGPL-2.1-or-later
;; Emacs as an editor of scenes, without a screen: emacs --batch -l nxml.el SCHEMA SCENE PLACE...
;; SCHEMA is a file, or - for the one that schemas.xml beside the scene names. Prints a line of JSON: what nxml-mode marks in
;; SCENE, and what it offers at each PLACE, a text in the scene after which the cursor stands.
(require 'nxml-mode)
(require 'rng-valid)
(require 'rng-nxml)
(require 'json)

(defun marked ()
  "What is underlined: line, text and message of each error."
  (let (found)
    (dolist (overlay (overlays-in (point-min) (point-max)) (nreverse found))
      (when (eq (overlay-get overlay 'category) 'rng-error)
        (let ((start (overlay-start overlay)))
          (push `((line . ,(line-number-at-pos start))
                  (text . ,(buffer-substring-no-properties start (overlay-end overlay)))
                  (message . ,(overlay-get overlay 'help-echo)))
                found))))))

(defun validate ()
  (rng-validate-mode 1)
  (while (rng-do-some-validation)))

(defun offered (place)
  "The words that completion offers after PLACE."
  (goto-char (point-min))
  (search-forward place)
  (let ((completion (rng-completion-at-point)))
    (and completion
         (let ((start (nth 0 completion)) (table (nth 2 completion)))
           (vconcat (sort (all-completions (buffer-substring-no-properties start (point)) table) #'string<))))))

(let* ((schema (pop command-line-args-left)) (scene (pop command-line-args-left)) offers)
  (find-file scene)
  (nxml-mode)
  (if (string= schema "-")
      (rng-auto-set-schema)
    (rng-set-schema-file-1 schema))
  (validate)
  (let ((marks (vconcat (marked))))
    (while command-line-args-left
      (push (or (offered (pop command-line-args-left)) []) offers))
    (princ (json-encode `((marked . ,marks) (offered . ,(vconcat (nreverse offers))))))
    (terpri)))
